#include "externals/phantom/output/trace.hpp"

#include "files/utf8_path.hpp"

#include <cerrno>
#include <cstring>

namespace tactus::phantom {

std::string Trace::open(const std::string& path) {
#ifdef _WIN32
  file_.reset(_wfopen(utf8_path(path).c_str(), L"wb")); // binary, so that all systems write the
                                                        // same bytes
#else
  file_.reset(std::fopen(path.c_str(), "w"));
#endif
  if (!file_)
    return std::strerror(errno);
  next_index_ = number_ = first_number_ = 0;
  std::fputs("tick,ms,x_mm,y_mm,z_mm,vx_m_per_s,vy_m_per_s,vz_m_per_s,fx_n,fy_n,fz_n,energy_j,"
             "buttons,asked_n,braked_n\n",
             file_.get());
  return {};
}

std::string Trace::close() {
  if (!file_)
    return {};
  const bool failed = std::ferror(file_.get()) != 0 || std::fflush(file_.get()) != 0;
  file_.reset();
  return failed ? "some rows could not be written: check that the disk is not full" : std::string();
}

void Trace::write(const haptic::Report& r, double ms) {
  if (!file_)
    return;
  if (r.tick.index < next_index_) // the servo restarted, after a reconnection
    first_number_ = number_;
  next_index_ = r.tick.index + 1;
  number_ = first_number_ + next_index_;
  const auto mm = r.state.position * 1e3;
  const auto& v = r.state.velocity;
  std::fprintf(file_.get(),
               "%llu,%.16g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%lu,%.9g,%.9g\n",
               static_cast<unsigned long long>(number_ - 1), ms, mm.x, mm.y, mm.z, v.x, v.y, v.z,
               r.force_n.x, r.force_n.y, r.force_n.z, r.energy_j,
               static_cast<unsigned long>(r.state.buttons), r.asked_n, r.taken_n);
}

} // namespace tactus::phantom
