#pragma once

#include "core/haptic/device/simulated_device.hpp"
#include "devices/servo_thread.hpp"
#include "net/servo_link.hpp"
#include "net/tcp_server.hpp"
#include "programs/haptic_server/options.hpp"

#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace tactus::haptic_server {

/// A device with its servo in one thread, and the server in another. Neither thread waits for the
/// other; the network's thread has normal priority, so a flood cannot delay the servo's ticks.
class Station {
public:
  ~Station();

  /// Returns an empty text if it serves, else what to do.
  [[nodiscard]] std::string open(const Options& options);
  /// Informs every client, ends the force and closes the device.
  void close();

  /// One line: the device, its force limit, and the address.
  [[nodiscard]] const std::string& description() const noexcept { return description_; }
  [[nodiscard]] std::vector<std::string> take_notices();
  /// True if clients have connected and all have left.
  [[nodiscard]] bool all_clients_left() const noexcept { return all_clients_left_; }
  [[nodiscard]] haptic::Exchange& exchange() noexcept { return servo_.exchange(); }
  [[nodiscard]] std::string trouble() const { return device_ ? device_->trouble() : std::string(); }

private:
  [[nodiscard]] std::string make_device(const Options& options);
  [[nodiscard]] std::string hold_simulated(const Options& options);
  [[nodiscard]] std::string serve(const Options& options, const std::string& token);
  void tick(double now_s);

  std::unique_ptr<haptic::Backend> device_;
  haptic::SimulatedDevice* simulated_ = nullptr;
  haptic::Servo servo_;
  net::RenderModel model_;
  devices::ServoThread servo_thread_;
  std::unique_ptr<net::Server> server_;
  std::unique_ptr<net::ServoLink> link_;
  std::unique_ptr<net::TcpServer> sockets_;
  std::thread network_;
  std::string description_;

  std::mutex mutex_;
  std::vector<std::string> notices_;
  std::atomic<bool> all_clients_left_{false};
};

} // namespace tactus::haptic_server
