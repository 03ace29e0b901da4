#pragma once

#include "core/haptic/chain/velocity.hpp"
#include "core/haptic/device/device.hpp"
#include "devices/driver.hpp"
#include "devices/falcon/frozen_encoder_detector.hpp"
#include "devices/falcon/kinematics.hpp"
#include "devices/falcon/stream.hpp"
#include "devices/open_devices.hpp"

#include <mutex>
#include <optional>

namespace tactus::devices::falcon {

/// A Novint Falcon over libusb. Settings: device WHICH, firmware FILE, reload, probe 0|1,
/// led COLOUR..., home, gain COUNTS. docs/devices/falcon.md
class Falcon final : public haptic::Backend {
public:
  ~Falcon() override { close(); }

  [[nodiscard]] std::string open() override;
  void cancel() noexcept override { cancelled_ = true; }
  void close() noexcept override;
  [[nodiscard]] haptic::Caps caps() const noexcept override;
  [[nodiscard]] bool read(const haptic::Tick& tick, haptic::State& state) noexcept override;
  [[nodiscard]] bool write(const Vec3& force_n) noexcept override;
  [[nodiscard]] std::string configure(std::span<const std::string> words) override;
  [[nodiscard]] haptic::Identity identity() const override;
  [[nodiscard]] std::string trouble() const override;

private:
  enum class Condition { kClosed, kOk, kHoming, kSilent, kUnreachable, kAtStop, kFrozen, kLost };
  struct Settings {
    std::string device, firmware;
    bool reload = false; ///< upload at the next opening even if firmware runs
    bool probe = false;  ///< ask an unknown device too whether firmware runs
  };
  [[nodiscard]] std::string boot(const Settings& settings);
  [[nodiscard]] bool process(const Frame& frame) noexcept;
  void home() noexcept;
  void update_condition(const haptic::Tick& tick, bool new_frame) noexcept;
  [[nodiscard]] std::string start_stream();
  [[nodiscard]] std::uint8_t lights(bool homed) const noexcept;

  mutable std::mutex mutex_; // guards settings and port; held briefly, never in the servo
  Settings settings_;
  Port port_;
  std::string loaded_path_; ///< port of the device loaded here; used by the opening thread
  OpenDevice open_;
  std::unique_ptr<Link> link_;
  std::unique_ptr<Stream> stream_;

  // Shared by the servo's thread and others.
  std::atomic<Condition> condition_{Condition::kClosed};
  std::atomic<double> counts_per_n_m_{10000};
  std::atomic<int> lights_{-1}; // flags of a Command, or -1 to follow the state
  std::atomic<bool> home_requested_{false}, stuck_{false}, cancelled_{false};

  // Used by the servo's thread only.
  haptic::VelocityEstimator estimator_;
  Frame frame_{};          // the newest with plausible arm angles
  Counts encoders_{};      // from the newest frame, plausible or not
  std::uint8_t flags_ = 0; // from the newest frame, plausible or not
  bool answered_ = false;
  std::optional<Counts> rejected_{};
  Vec3 position_ = kCentre, velocity_{};
  FrozenEncoderDetector frozen_detector_;
  Vec3 commanded_n_{};   // of the last write, before frozen_detector_'s gain
  bool changed_ = false; // true if a count changed in this tick
  bool homed_ = false, homing_ = false, unreachable_ = false;
  std::atomic<bool> moved_{false}; // true once a count has changed since the opening
  double time_s_ = 0, period_s_ = 1e-3;
  double last_frame_s_ = 0, open_s_ = 0, homed_s_ = 0, homing_s_ = 0;
};

} // namespace tactus::devices::falcon
