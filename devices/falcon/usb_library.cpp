#include "devices/falcon/usb_library.hpp"

#include <array>

namespace tactus::devices::falcon {

std::string UsbLibrary::load() {
  constexpr std::array<const char*, 4> kNames{"libusb-1.0.so.0", "libusb-1.0.so",
                                              "libusb-1.0.dylib", "libusb-1.0.dll"};
  if (!library_.load(kNames))
    return "libusb 1.0 cannot be loaded (" + library_.error() +
           "): install Debian's libusb-1.0-0, or libusb from libusb.info";
  const char* missing = nullptr;
  const auto find = [&](const char* name, auto& function) {
    if (!library_.symbol(name, function))
      missing = name;
  };
  find("libusb_init", init);
  find("libusb_exit", exit);
  find("libusb_get_device_list", get_device_list);
  find("libusb_free_device_list", free_device_list);
  find("libusb_get_device_descriptor", get_device_descriptor);
  find("libusb_get_bus_number", get_bus_number);
  find("libusb_get_port_numbers", get_port_numbers);
  find("libusb_get_string_descriptor_ascii", get_string_descriptor_ascii);
  find("libusb_open", open);
  find("libusb_close", close);
  find("libusb_set_auto_detach_kernel_driver", set_auto_detach_kernel_driver);
  find("libusb_claim_interface", claim_interface);
  find("libusb_release_interface", release_interface);
  find("libusb_control_transfer", control_transfer);
  find("libusb_bulk_transfer", bulk_transfer);
  find("libusb_alloc_transfer", alloc_transfer);
  find("libusb_free_transfer", free_transfer);
  find("libusb_submit_transfer", submit_transfer);
  find("libusb_cancel_transfer", cancel_transfer);
  find("libusb_handle_events_timeout_completed", handle_events_timeout_completed);
  find("libusb_error_name", error_name);
  if (!missing)
    return {};
  return library_.name() + " has no " + missing + ": install libusb 1.0.16 or newer";
}

} // namespace tactus::devices::falcon
