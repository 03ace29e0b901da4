#include "externals/child_process.hpp"
#include "files/utf8_path.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cwchar>
#include <system_error>
#include <utility>

#include <windows.h>

namespace tactus {
namespace {

constexpr std::size_t kMaxStderrBytes = 4096;
constexpr DWORD kPipeBytes = 1 << 16;

std::string sentence(DWORD error) {
  return std::system_category().message(static_cast<int>(error));
}

/// Owns a handle and closes it.
class Handle {
public:
  explicit Handle(HANDLE handle = nullptr) : handle_(handle) {}
  Handle(Handle&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Handle() { reset(); }
  void reset() {
    if (*this)
      CloseHandle(std::exchange(handle_, nullptr));
  }
  explicit operator bool() const { return handle_ && handle_ != INVALID_HANDLE_VALUE; }
  [[nodiscard]] HANDLE get() const { return handle_; }

private:
  HANDLE handle_;
};

/// This process's end of a pipe, with at most one overlapped transfer. Windows uses the buffer
/// until that transfer has ended.
class PipeEnd {
public:
  PipeEnd() = default;
  PipeEnd(const PipeEnd&) = delete;
  PipeEnd& operator=(const PipeEnd&) = delete;
  ~PipeEnd() { close(); }

  /// Makes a pipe; returns the child's end, which it inherits.
  [[nodiscard]] Handle open(bool child_reads) {
    static std::atomic<unsigned> number{0};
    std::array<wchar_t, 96> name{};
    std::swprintf(name.data(), name.size(), L"\\\\.\\pipe\\tactus-%lu-%u", GetCurrentProcessId(),
                  ++number);
    pipe_ = Handle(CreateNamedPipeW(name.data(),
                                    (child_reads ? PIPE_ACCESS_OUTBOUND : PIPE_ACCESS_INBOUND) |
                                        FILE_FLAG_OVERLAPPED | FILE_FLAG_FIRST_PIPE_INSTANCE,
                                    PIPE_TYPE_BYTE | PIPE_REJECT_REMOTE_CLIENTS, 1, kPipeBytes,
                                    kPipeBytes, 0, nullptr));
    event_ = Handle(CreateEventW(nullptr, TRUE, FALSE, nullptr));
    if (!pipe_ || !event_)
      return Handle();
    SECURITY_ATTRIBUTES inherited{sizeof inherited, nullptr, TRUE};
    return Handle(CreateFileW(name.data(), child_reads ? GENERIC_READ : GENERIC_WRITE, 0,
                              &inherited, OPEN_EXISTING, 0, nullptr));
  }

  /// Ends a pending transfer, then closes the pipe.
  void close() {
    if (pipe_ && under_way_) {
      DWORD count = 0;
      CancelIoEx(pipe_.get(), &transfer_);
      GetOverlappedResult(pipe_.get(), &transfer_, &count, TRUE);
      under_way_ = false;
    }
    pipe_.reset();
  }

  /// Returns the number of accepted bytes, 0 while the last transfer is pending.
  std::size_t write(std::span<const std::byte> bytes) {
    DWORD count = 0;
    if (bytes.empty() || !pipe_ || !finished(count))
      return 0;
    buffer_.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(
                                                      bytes.size(), kPipeBytes)));
    begin();
    const auto size = static_cast<DWORD>(buffer_.size());
    under_way_ = WriteFile(pipe_.get(), buffer_.data(), size, nullptr, &transfer_) ||
                 GetLastError() == ERROR_IO_PENDING;
    return under_way_ ? size : 0;
  }

  /// Passes the bytes that have arrived to `take`, up to the limit; false at the end.
  template <class Take> bool read(std::size_t limit, Take take) {
    while (limit > 0) {
      DWORD count = 0;
      if (!finished(count))
        return true;
      if (failed_)
        return false;
      received_ += count;
      const std::size_t piece = std::min(limit, received_ - taken_);
      take(std::span(buffer_).subspan(taken_, piece));
      taken_ += piece;
      limit -= piece;
      if (taken_ < received_)
        return true;
      start_reading();
    }
    return true;
  }

  void wait(DWORD ms) const {
    if (under_way_)
      WaitForSingleObject(event_.get(), ms);
  }
  [[nodiscard]] bool has_rest() const { return taken_ < received_; }
  void start_reading() {
    taken_ = received_ = 0;
    buffer_.resize(kPipeBytes);
    begin();
    under_way_ = ReadFile(pipe_.get(), buffer_.data(), kPipeBytes, nullptr, &transfer_) ||
                 GetLastError() == ERROR_IO_PENDING;
    failed_ = !under_way_;
  }

private:
  void begin() {
    transfer_ = {};
    transfer_.hEvent = event_.get();
    ResetEvent(event_.get());
  }
  /// True if no transfer is pending; `count` is the number of bytes of a transfer that has just
  /// ended.
  bool finished(DWORD& count) {
    count = 0;
    if (!under_way_)
      return true;
    if (!GetOverlappedResult(pipe_.get(), &transfer_, &count, FALSE)) {
      if (GetLastError() == ERROR_IO_INCOMPLETE)
        return false;
      count = 0;
      failed_ = true;
    }
    under_way_ = false;
    return true;
  }

  Handle pipe_, event_;
  OVERLAPPED transfer_{};
  std::vector<std::byte> buffer_;
  std::size_t taken_ = 0, received_ = 0;
  bool under_way_ = false, failed_ = false;
};

/// Appends one argument to a command line, quoted as CommandLineToArgvW expects it.
void append_quoted(std::wstring& line, const std::wstring& word) {
  line += line.empty() ? L"\"" : L" \"";
  std::size_t backslashes = 0;
  for (const wchar_t c : word) {
    if (c == L'"')
      line.append(backslashes + 1, L'\\');
    backslashes = c == L'\\' ? backslashes + 1 : 0;
    line += c;
  }
  line.append(backslashes, L'\\');
  line += L'"';
}

/// The handles that a child inherits, and no others.
class Inherited {
public:
  explicit Inherited(std::array<HANDLE, 3> handles) : handles_(handles) {
    SIZE_T size = 0;
    InitializeProcThreadAttributeList(nullptr, 1, 0, &size);
    memory_.resize(size);
    InitializeProcThreadAttributeList(list(), 1, 0, &size);
    UpdateProcThreadAttribute(list(), 0, PROC_THREAD_ATTRIBUTE_HANDLE_LIST, handles_.data(),
                              sizeof handles_, nullptr, nullptr);
  }
  ~Inherited() { DeleteProcThreadAttributeList(list()); }
  Inherited(const Inherited&) = delete;
  Inherited& operator=(const Inherited&) = delete;
  LPPROC_THREAD_ATTRIBUTE_LIST list() {
    return reinterpret_cast<LPPROC_THREAD_ATTRIBUTE_LIST>(memory_.data());
  }

private:
  std::array<HANDLE, 3> handles_;
  std::vector<std::byte> memory_;
};

} // namespace

struct ChildProcess::Process {
  Handle process;
  PipeEnd input, output, errors;
  std::string stderr_tail; ///< last part of its stderr
  DWORD status = 0;

  void read_errors() {
    errors.read(1 << 16, [this](std::span<const std::byte> piece) { // the child may never stop
      stderr_tail.append(reinterpret_cast<const char*>(piece.data()), piece.size());
    });
    if (stderr_tail.size() > kMaxStderrBytes)
      stderr_tail.erase(0, stderr_tail.size() - kMaxStderrBytes);
  }
};

ChildProcess::ChildProcess(std::unique_ptr<Process> process) : process_(std::move(process)) {}

std::unique_ptr<ChildProcess> ChildProcess::start(const std::vector<std::string>& words,
                                                  std::string& refusal) {
  auto process = std::make_unique<Process>();
  Handle input = process->input.open(true), output = process->output.open(false),
         errors = process->errors.open(false);
  if (!input || !output || !errors) {
    refusal = "cannot create a pipe to the program: " + sentence(GetLastError());
    return nullptr;
  }
  std::wstring line;
  for (const std::string& word : words)
    append_quoted(line, utf8_path(word).wstring());
  Inherited inherited({input.get(), output.get(), errors.get()});
  STARTUPINFOEXW startup{};
  startup.StartupInfo.cb = sizeof startup;
  startup.StartupInfo.dwFlags = STARTF_USESTDHANDLES;
  startup.StartupInfo.hStdInput = input.get();
  startup.StartupInfo.hStdOutput = output.get();
  startup.StartupInfo.hStdError = errors.get();
  startup.lpAttributeList = inherited.list();
  PROCESS_INFORMATION made{};
  if (!CreateProcessW(utf8_path(words[0]).c_str(), line.data(), nullptr, nullptr, TRUE,
                      CREATE_NO_WINDOW | EXTENDED_STARTUPINFO_PRESENT, nullptr, nullptr,
                      &startup.StartupInfo, &made)) {
    refusal = words[0] + ": cannot start: " + sentence(GetLastError());
    return nullptr;
  }
  CloseHandle(made.hThread);
  process->process = Handle(made.hProcess);
  process->output.start_reading();
  process->errors.start_reading();
  return std::unique_ptr<ChildProcess>(new ChildProcess(std::move(process)));
}

ChildProcess::~ChildProcess() { static_cast<void>(end(0)); }

std::size_t ChildProcess::send(std::span<const std::byte> bytes) {
  return process_->input.write(bytes);
}

bool ChildProcess::receive(std::vector<std::byte>& into, std::size_t limit) {
  process_->read_errors();
  return process_->output.read(limit, [&](std::span<const std::byte> piece) {
    into.insert(into.end(), piece.begin(), piece.end());
  });
}

void ChildProcess::wait(double seconds) {
  if (!process_->output.has_rest())
    process_->output.wait(static_cast<DWORD>(std::ceil(1e3 * seconds)));
}

std::string ChildProcess::end(double grace_s) {
  Process& p = *process_;
  if (p.process) {
    p.input.close();
    p.output.close();
    const auto grace = static_cast<DWORD>(std::ceil(1e3 * std::max(grace_s, 0.0)));
    if (WaitForSingleObject(p.process.get(), grace) != WAIT_OBJECT_0) {
      TerminateProcess(p.process.get(), 1);
      WaitForSingleObject(p.process.get(), INFINITE);
    }
    GetExitCodeProcess(p.process.get(), &p.status);
    p.process.reset();
    p.read_errors();
    p.errors.close();
  }
  if (const std::size_t last = p.stderr_tail.find_last_not_of("\r\n"); last != std::string::npos) {
    const std::size_t before = p.stderr_tail.find_last_of("\r\n", last); // npos + 1 is 0
    return p.stderr_tail.substr(before + 1, last - before);
  }
  return "status " + std::to_string(p.status);
}

} // namespace tactus
