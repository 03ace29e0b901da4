#include "fem/io/sandbox.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <initializer_list>
#include <linux/audit.h>
#include <linux/capability.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <vector>

namespace tactus::fem {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kAddressSanitizer = true;
#elif defined(__has_feature)
constexpr bool kAddressSanitizer = __has_feature(address_sanitizer);
#else
constexpr bool kAddressSanitizer = false;
#endif

void limit(int resource, std::uint64_t value) noexcept {
  rlimit now{};
  if (getrlimit(static_cast<__rlimit_resource_t>(resource), &now) != 0)
    return;
  now.rlim_max = now.rlim_cur = std::min<rlim_t>(value, now.rlim_max);
  setrlimit(static_cast<__rlimit_resource_t>(resource), &now);
}

/// Bytes of address space in use, or 0 if that cannot be read.
std::uint64_t address_space() noexcept {
  unsigned long long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%llu", &pages) != 1)
      pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t kArchitecture = 0;
#endif

/// A seccomp filter, built rule by rule (Linux kernel documentation, "Seccomp BPF").
class Filter {
public:
  Filter() {
    load(offsetof(seccomp_data, arch));
    unless_equal(kArchitecture, SECCOMP_RET_KILL_PROCESS);
    load(offsetof(seccomp_data, nr));
#if defined(__x86_64__)
    // The x32 calls are the same calls under other numbers.
    add(BPF_STMT(BPF_ALU | BPF_AND | BPF_K, 0xBFFFFFFF));
#endif
  }
  void refuse(long call, int error = EPERM) {
    if_equal(static_cast<std::uint32_t>(call), refusal(error));
  }
  /// Refuses the call if any of `bits` is set in the low word of an argument.
  void refuse_bits(long call, unsigned argument, std::uint32_t bits, int error) {
    add(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 4));
    load(low_word(argument));
    add(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, bits, 0, 1));
    add(BPF_STMT(BPF_RET | BPF_K, refusal(error)));
    add(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  }
  /// Allows the call only with one of these values in the low word of an argument, or, if `listed`
  /// is false, only with a value that is not listed.
  void allow_values(long call, unsigned argument, std::initializer_list<std::uint32_t> values,
                    bool listed = true) {
    auto left = static_cast<unsigned char>(values.size());
    add(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0,
                 static_cast<unsigned char>(left + 3)));
    load(low_word(argument));
    for (const std::uint32_t value : values)
      add(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, left--, 0));
    add(BPF_STMT(BPF_RET | BPF_K, listed ? refusal(EPERM) : SECCOMP_RET_ALLOW));
    add(BPF_STMT(BPF_RET | BPF_K, listed ? SECCOMP_RET_ALLOW : refusal(EPERM)));
  }
  /// Refuses the call unless an argument, a pointer of 64 bits, is null.
  void allow_null(long call, unsigned argument) {
    add(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 6));
    load(low_word(argument));
    add(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, 0, 0, 2));
    load(low_word(argument) + 4);
    add(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, 0, 1, 0));
    add(BPF_STMT(BPF_RET | BPF_K, refusal(EPERM)));
    add(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  }
  /// Refuses calls from this number on as unknown.
  void refuse_from(std::uint32_t call) {
    add(BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, call, 0, 1));
    add(BPF_STMT(BPF_RET | BPF_K, refusal(ENOSYS)));
  }
  /// Allows the call only if the low word of an argument, masked, has this value.
  void allow_only(long call, unsigned argument, std::uint32_t mask, std::uint32_t value) {
    add(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 5));
    load(low_word(argument));
    add(BPF_STMT(BPF_ALU | BPF_AND | BPF_K, mask));
    add(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 1, 0));
    add(BPF_STMT(BPF_RET | BPF_K, refusal(EPERM)));
    add(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  }
  bool install() {
    add(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
    const sock_fprog program{static_cast<unsigned short>(code_.size()), code_.data()};
    return prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program, 0, 0) == 0;
  }

private:
  static std::uint32_t refusal(int error) {
    return SECCOMP_RET_ERRNO | (static_cast<std::uint32_t>(error) & SECCOMP_RET_DATA);
  }
  static std::size_t low_word(unsigned argument) {
    return offsetof(seccomp_data, args) + 8 * argument; // both architectures are little-endian
  }
  void add(sock_filter statement) { code_.push_back(statement); }
  void load(std::size_t offset) {
    add(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset)));
  }
  void if_equal(std::uint32_t value, std::uint32_t result) {
    add(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 1));
    add(BPF_STMT(BPF_RET | BPF_K, result));
  }
  void unless_equal(std::uint32_t value, std::uint32_t result) {
    add(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 1, 0));
    add(BPF_STMT(BPF_RET | BPF_K, result));
  }
  std::vector<sock_filter> code_;
};

// Not split, because it is a table of the system calls.
bool install_filter() {
  if (kArchitecture == 0)
    return false;
  Filter filter;
  constexpr std::uint32_t kWriting = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND;
  filter.refuse_bits(SYS_openat, 2, kWriting, EACCES);
  filter.allow_only(SYS_clone, 0, CLONE_THREAD, CLONE_THREAD);
  filter.allow_values(SYS_tgkill, 0, {static_cast<std::uint32_t>(getpid())}); // abort() uses it
  filter.allow_null(SYS_prlimit64, 2); // limits may be read, not set
  // F_SETOWN and F_SETSIG would send any signal to any process; locks would stop other programs.
  filter.allow_values(SYS_fcntl, 1, {F_DUPFD, F_DUPFD_CLOEXEC, F_GETFD, F_SETFD, F_GETFL, F_SETFL});
  filter.allow_values(SYS_prctl, 0, {PR_SET_PDEATHSIG}, false); // otherwise the process could
                                                                // outlive the program
  filter.refuse(SYS_ioctl, ENOTTY); // would type into terminals or change their modes
  // The first call that did not exist when this was written: fchmodat2, of Linux 6.6.
  constexpr std::uint32_t kFirstUnknown = 452;
  filter.refuse_from(kFirstUnknown);
  // Refused as unknown, so that the C library uses the calls above instead.
  for (const long call : {SYS_clone3, SYS_openat2, SYS_io_uring_setup})
    filter.refuse(call, ENOSYS);
  for (const long call : {SYS_execve,
                          SYS_execveat,
                          SYS_socket,
                          SYS_socketpair,
                          SYS_connect,
                          SYS_bind,
                          SYS_ptrace,
                          SYS_process_vm_readv,
                          SYS_process_vm_writev,
                          SYS_kill,
                          SYS_tkill,
                          SYS_rt_sigqueueinfo,
                          SYS_rt_tgsigqueueinfo,
                          SYS_pidfd_send_signal,
                          SYS_unlinkat,
                          SYS_renameat,
                          SYS_renameat2,
                          SYS_mkdirat,
                          SYS_linkat,
                          SYS_symlinkat,
                          SYS_mknodat,
                          SYS_truncate,
                          SYS_ftruncate,
                          SYS_fchmod,
                          SYS_fchmodat,
                          SYS_fchown,
                          SYS_fchownat,
                          SYS_utimensat,
                          SYS_setxattr,
                          SYS_lsetxattr,
                          SYS_fsetxattr,
                          SYS_removexattr,
                          SYS_lremovexattr,
                          SYS_fremovexattr,
                          SYS_mount,
                          SYS_umount2,
                          SYS_unshare,
                          SYS_setns,
                          SYS_chroot,
                          SYS_bpf,
                          SYS_keyctl,
                          SYS_add_key,
                          SYS_request_key,
                          SYS_open_by_handle_at,
                          SYS_pidfd_getfd,
                          SYS_kcmp,
                          SYS_process_madvise,
                          SYS_move_pages,
                          SYS_migrate_pages,
                          SYS_setpriority,
                          SYS_ioprio_set,
                          SYS_sched_setscheduler,
                          SYS_sched_setparam,
                          SYS_sched_setattr,
                          SYS_sched_setaffinity,
                          SYS_flock,
                          SYS_setrlimit,
                          SYS_shmget,
                          SYS_shmat,
                          SYS_shmctl,
                          SYS_semget,
                          SYS_semop,
                          SYS_semtimedop,
                          SYS_semctl,
                          SYS_msgget,
                          SYS_msgsnd,
                          SYS_msgrcv,
                          SYS_msgctl,
                          SYS_mq_open,
                          SYS_mq_unlink,
                          SYS_userfaultfd,
                          SYS_perf_event_open})
    filter.refuse(call);
#if defined(__x86_64__)
  filter.refuse_bits(SYS_open, 1, kWriting, EACCES);
  for (const long call : {SYS_creat, SYS_fork, SYS_vfork, SYS_unlink, SYS_rename, SYS_mkdir,
                          SYS_rmdir, SYS_link, SYS_symlink, SYS_mknod, SYS_chmod, SYS_chown,
                          SYS_lchown, SYS_utime, SYS_utimes, SYS_futimesat})
    filter.refuse(call);
#endif
  return filter.install();
}

/// Keeps only the capability to read other users' files. (capabilities(7))
void drop_capabilities() noexcept {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> capabilities{};
  if (syscall(SYS_capget, &header, capabilities.data()) != 0)
    return;
  constexpr std::uint32_t kReading = 1u << CAP_DAC_READ_SEARCH;
  const std::uint32_t kept = capabilities[0].permitted & kReading;
  capabilities = {};
  capabilities[0].permitted = capabilities[0].effective = kept;
  syscall(SYS_capset, &header, capabilities.data());
}

} // namespace

void leave_terminal_and_environment() noexcept {
  setsid();
  clearenv();
  for (int number = 1; number < NSIG; ++number)
    if (!kAddressSanitizer || number == SIGINT || number == SIGTERM)
      std::signal(number, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
}

void enter_sandbox(std::uint64_t memory_bytes, std::uint64_t cpu_seconds) noexcept {
  if (!kAddressSanitizer)
    limit(RLIMIT_AS, address_space() + memory_bytes);
  limit(RLIMIT_CPU, cpu_seconds);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_FSIZE, 0);
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  drop_capabilities();
  try {
    (void)install_filter();
  } catch (...) { // no memory for the list of rules: the limits above remain
  }
}

bool under_address_sanitizer() noexcept { return kAddressSanitizer; }

} // namespace tactus::fem
