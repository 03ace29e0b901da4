#pragma once

#include "devices/driver.hpp"
#include "devices/shared_library.hpp"
#include "tests/devices/cancelled_opening.hpp"

#include <doctest/doctest.h>

#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>

/// Drivers on a stand-in for their vendor's library, which a variable of the environment names and
/// another puts into a mode; what holds for every one of them.
namespace tactus {

/// The stand-in, loaded beside the driver, so it is the same one.
struct VendorLibrary {
  VendorLibrary(const char* path_variable, const char* path, const char* mode_variable,
                const char* mode) {
    setenv(path_variable, path, 1);
    setenv(mode_variable, mode, 1);
    REQUIRE(library.load({&path, 1}));
  }
  template <class Function> Function* hook(const char* name) {
    Function* function = nullptr;
    REQUIRE(library.symbol(name, function));
    return function;
  }
  devices::SharedLibrary library;
};

/// The stand-in and a device that is open on it.
template <class Fake> struct OpenedOn {
  explicit OpenedOn(const char* mode = "") : fake(mode), device(Fake::make()) {
    REQUIRE(device->open() == "");
  }
  Fake fake;
  std::unique_ptr<haptic::Backend> device;
};

inline void says(const std::string& sentence, const char* words) {
  CAPTURE(sentence);
  CHECK(sentence.find(words) != std::string::npos);
}

/// Without the library, and with one that lacks a function.
template <class Fake>
void is_told_of_its_library(const char* install, const char* incomplete, const char* function) {
  const devices::Driver& driver = *devices::find_driver(Fake::kDriver);
  setenv(Fake::kPathVariable, "/nowhere/library.so", 1);
  says(Fake::make()->open(), "/nowhere/library.so");
  says(Fake::make()->open(), install);
  CHECK(driver.problem() != "");
  CHECK(driver.list().empty());
  setenv(Fake::kPathVariable, incomplete, 1);
  says(Fake::make()->open(), function);
}

/// Whatever is listed, opened and closed; a device that is open is refused to another and goes on.
template <class Fake>
void is_loaded_and_opened_once(const char* serial, const char* loads_variable) {
  const Fake fake;
  const devices::Driver& driver = *devices::find_driver(Fake::kDriver);
  const auto device = Fake::make(), other = Fake::make();
  for (int round = 0; round < 3; ++round) {
    CHECK(driver.problem() == "");
    CHECK(driver.list().size() == 1);
    REQUIRE(device->open() == "");
    CHECK(driver.list().at(0).identity.serial == serial);
    CHECK(driver.list().at(0).state == "open in this program");
    says(other->open(), "already open in this program");
    other->close();
    CHECK(driver.list().at(0).state == "open in this program");
    device->close();
    CHECK(driver.list().at(0).state != "open in this program");
  }
  CHECK(other->open() == "");
  other->close();
  CHECK(std::string(std::getenv(loads_variable)) == "1");
}

/// An opening in vain takes half a second, with a sentence, and is cancelled when it is asked to.
template <class Fake> void opens_in_vain(const char* mode, const char* words) {
  const Fake fake(mode);
  const auto device = Fake::make();
  const auto begun = std::chrono::steady_clock::now();
  says(device->open(), words);
  CHECK(std::chrono::steady_clock::now() - begun >= std::chrono::milliseconds(500));
  says(cancelled_opening(*device), "cancelled");
}

} // namespace tactus
