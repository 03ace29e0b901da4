#include "externals/phantom/net_driver.hpp"

#include "devices/driver.hpp"
#ifdef TACTUS_NET
#include "net/remote_device.hpp"
#endif

namespace tactus::phantom {

#ifdef TACTUS_NET
namespace {

// It lists no devices: the user gives HOST PORT.
const devices::Driver kNetDriver{
    "net", "a device on another computer, through haptic_server", [] { return std::string(); },
    [] { return std::vector<devices::Found>(); },
    []() -> std::unique_ptr<haptic::Backend> { return std::make_unique<net::RemoteDevice>(); }};

} // namespace

void add_net_driver() noexcept { devices::add_driver(kNetDriver); }
#else
void add_net_driver() noexcept {}
#endif

} // namespace tactus::phantom
