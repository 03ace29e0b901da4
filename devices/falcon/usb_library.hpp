#pragma once

#include "devices/shared_library.hpp"

#include <string>

#include <libusb.h>

namespace tactus::devices::falcon {

/// The functions of libusb 1.0 that the driver calls, found when they are needed.
class UsbLibrary {
  SharedLibrary library_;

public:
  Function<decltype(libusb_init)> init{library_, "libusb_init"};
  Function<decltype(libusb_exit)> exit{library_, "libusb_exit"};
  Function<decltype(libusb_get_device_list)> get_device_list{library_, "libusb_get_device_list"};
  Function<decltype(libusb_free_device_list)> free_device_list{library_, "libusb_free_device_list"};
  Function<decltype(libusb_get_device_descriptor)> get_device_descriptor{
      library_, "libusb_get_device_descriptor"};
  Function<decltype(libusb_get_bus_number)> get_bus_number{library_, "libusb_get_bus_number"};
  Function<decltype(libusb_get_port_numbers)> get_port_numbers{library_, "libusb_get_port_numbers"};
  Function<decltype(libusb_get_string_descriptor_ascii)> get_string_descriptor_ascii{
      library_, "libusb_get_string_descriptor_ascii"};
  Function<decltype(libusb_open)> open{library_, "libusb_open"};
  Function<decltype(libusb_close)> close{library_, "libusb_close"};
  Function<decltype(libusb_set_auto_detach_kernel_driver)> set_auto_detach_kernel_driver{
      library_, "libusb_set_auto_detach_kernel_driver"};
  Function<decltype(libusb_claim_interface)> claim_interface{library_, "libusb_claim_interface"};
  Function<decltype(libusb_release_interface)> release_interface{library_,
                                                                 "libusb_release_interface"};
  Function<decltype(libusb_control_transfer)> control_transfer{library_, "libusb_control_transfer"};
  Function<decltype(libusb_bulk_transfer)> bulk_transfer{library_, "libusb_bulk_transfer"};
  Function<decltype(libusb_alloc_transfer)> alloc_transfer{library_, "libusb_alloc_transfer"};
  Function<decltype(libusb_free_transfer)> free_transfer{library_, "libusb_free_transfer"};
  Function<decltype(libusb_submit_transfer)> submit_transfer{library_, "libusb_submit_transfer"};
  Function<decltype(libusb_cancel_transfer)> cancel_transfer{library_, "libusb_cancel_transfer"};
  Function<decltype(libusb_handle_events_timeout_completed)> handle_events_timeout_completed{
      library_, "libusb_handle_events_timeout_completed"};
  Function<decltype(libusb_error_name)> error_name{library_, "libusb_error_name"};

  /// Returns an empty text if all functions were found, else a sentence that names what to install.
  std::string load();
};

} // namespace tactus::devices::falcon
