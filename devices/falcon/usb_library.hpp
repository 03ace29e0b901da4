#pragma once

#include "devices/shared_library.hpp"

#include <string>

#include <libusb.h>

namespace tactus::devices::falcon {

/// The functions of libusb 1.0 that the driver calls, found when they are needed.
struct UsbLibrary {
  decltype(&::libusb_init) init = nullptr;
  decltype(&::libusb_exit) exit = nullptr;
  decltype(&::libusb_get_device_list) get_device_list = nullptr;
  decltype(&::libusb_free_device_list) free_device_list = nullptr;
  decltype(&::libusb_get_device_descriptor) get_device_descriptor = nullptr;
  decltype(&::libusb_get_bus_number) get_bus_number = nullptr;
  decltype(&::libusb_get_port_numbers) get_port_numbers = nullptr;
  decltype(&::libusb_get_string_descriptor_ascii) get_string_descriptor_ascii = nullptr;
  decltype(&::libusb_open) open = nullptr;
  decltype(&::libusb_close) close = nullptr;
  decltype(&::libusb_set_auto_detach_kernel_driver) set_auto_detach_kernel_driver = nullptr;
  decltype(&::libusb_claim_interface) claim_interface = nullptr;
  decltype(&::libusb_release_interface) release_interface = nullptr;
  decltype(&::libusb_control_transfer) control_transfer = nullptr;
  decltype(&::libusb_bulk_transfer) bulk_transfer = nullptr;
  decltype(&::libusb_alloc_transfer) alloc_transfer = nullptr;
  decltype(&::libusb_free_transfer) free_transfer = nullptr;
  decltype(&::libusb_submit_transfer) submit_transfer = nullptr;
  decltype(&::libusb_cancel_transfer) cancel_transfer = nullptr;
  decltype(&::libusb_handle_events_timeout_completed) handle_events_timeout_completed = nullptr;
  decltype(&::libusb_error_name) error_name = nullptr;

  /// Empty when all are there, else a sentence that says what to install.
  std::string load();

private:
  SharedLibrary library_;
};

} // namespace tactus::devices::falcon
