#include "devices/falcon/usb_library.hpp"

#include <array>

namespace tactus::devices::falcon {

std::string UsbLibrary::load() {
  constexpr std::array<const char*, 4> kNames{"libusb-1.0.so.0", "libusb-1.0.so",
                                              "libusb-1.0.dylib", "libusb-1.0.dll"};
  if (!library_.load(kNames))
    return "libusb 1.0 cannot be loaded (" + library_.error() +
           "): install Debian's libusb-1.0-0, or libusb from libusb.info";
  RequiredSymbols need(library_);
  need("libusb_init", init);
  need("libusb_exit", exit);
  need("libusb_get_device_list", get_device_list);
  need("libusb_free_device_list", free_device_list);
  need("libusb_get_device_descriptor", get_device_descriptor);
  need("libusb_get_bus_number", get_bus_number);
  need("libusb_get_port_numbers", get_port_numbers);
  need("libusb_get_string_descriptor_ascii", get_string_descriptor_ascii);
  need("libusb_open", open);
  need("libusb_close", close);
  need("libusb_set_auto_detach_kernel_driver", set_auto_detach_kernel_driver);
  need("libusb_claim_interface", claim_interface);
  need("libusb_release_interface", release_interface);
  need("libusb_control_transfer", control_transfer);
  need("libusb_bulk_transfer", bulk_transfer);
  need("libusb_alloc_transfer", alloc_transfer);
  need("libusb_free_transfer", free_transfer);
  need("libusb_submit_transfer", submit_transfer);
  need("libusb_cancel_transfer", cancel_transfer);
  need("libusb_handle_events_timeout_completed", handle_events_timeout_completed);
  need("libusb_error_name", error_name);
  if (const char* missing = need.missing())
    return library_.name() + " has no " + missing + ": install libusb 1.0.16 or newer";
  return {};
}

} // namespace tactus::devices::falcon
