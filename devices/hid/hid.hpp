#pragma once

#include "core/dsp/mailbox.hpp"
#include "core/haptic/device/device.hpp"
#include "core/haptic/device/linear_glide.hpp"
#include "devices/hid/axis_table.hpp"
#include "devices/hid/catalogue.hpp"

#include <atomic>
#include <mutex>
#include <thread>

namespace tactus::devices::hid {

/// A SpaceMouse, or any HID with axes: position without force. A separate thread waits for reports
/// and decodes them; the servo reads the newest from a mailbox. Reports are several ticks apart, so
/// a deflection used as position is interpolated between them (linear_glide.hpp): its velocity is
/// then the hand's, and a contact in a scene is reported as a hit. Settings: device WHICH, mapping
/// position|rate, speed MM_PER_S, deadzone PERCENT, led 0|1, table FILE, transport
/// any|hidraw|libusb. docs/devices/hid.md
class Hid final : public haptic::Backend {
public:
  ~Hid() override { close(); }

  [[nodiscard]] std::string open() override;
  void close() noexcept override;
  [[nodiscard]] haptic::Caps caps() const noexcept override;
  [[nodiscard]] bool read(const haptic::Tick& tick, haptic::State& state) noexcept override;
  /// Accepts the force without effect, because there are no motors.
  [[nodiscard]] bool write(const Vec3& force_n) noexcept override;
  [[nodiscard]] std::string configure(std::span<const std::string> words) override;
  [[nodiscard]] haptic::Identity identity() const override;
  [[nodiscard]] std::string trouble() const override;

private:
  struct Settings {
    std::string device, table;
    Transport transport = Transport::kAny;
  };
  [[nodiscard]] std::string find(const Settings& settings, Entry& entry);
  [[nodiscard]] std::string prepare(const Settings& settings, const Entry& entry);
  void read_reports() noexcept;
  void light(bool on) noexcept;
  [[nodiscard]] std::string set_number(const std::string& name, const std::string& text);
  [[nodiscard]] std::string set_name(const std::string& name, const std::string& value);

  mutable std::mutex mutex_; // guards the next two; held briefly, never in the servo
  Settings settings_;
  haptic::Identity identity_;

  HidLibrary* library_ = nullptr;
  hid_device* device_ = nullptr;
  bool space_mouse_ = false;
  std::thread reader_;

  // Shared by the threads.
  Mailbox<Knob> knobs_;
  std::atomic<bool> stopping_{false}, lost_{false}, rate_{false}, light_{true};
  std::atomic<double> speed_m_per_s_{0.1}, dead_zone_{0.03};
  std::atomic<int> battery_percent_{-1};

  Decoder decoder_; // used by the listener thread
  AxisTable table_; // fixed while it is open
  std::uint32_t axes_ = 0;
  double step_ = 0;
  bool has_buttons_ = false;

  // Used by the servo's thread.
  Vec3 position_{};
  haptic::LinearGlide glide_; // interpolates a deflection used as position
  double time_s_ = 0;
  bool begun_ = false;
};

} // namespace tactus::devices::hid
