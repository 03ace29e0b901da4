#include "devices/driver.hpp"
#include "devices/falcon/stream.hpp"
#include "files/worker.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <string>

#include <dlfcn.h>
#include <pthread.h>

using namespace tactus;

namespace {
std::atomic<int> allowed{1000}; ///< threads that may still be started
}

// In front of the system's: std::thread throws when it refuses.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes,
                              void* (*start)(void*), void* argument) {
  if (allowed.fetch_sub(1) <= 0)
    return EAGAIN;
  using Create = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  static const auto create = reinterpret_cast<Create>(dlsym(RTLD_NEXT, "pthread_create"));
  return create(thread, attributes, start, argument);
}

namespace {

struct Refuse {
  explicit Refuse(int after = 0) { allowed = after; }
  ~Refuse() { allowed = 1000; }
};

std::string open_refused(const char* driver) {
  const auto device = devices::find_driver(driver)->make();
  std::string sentence;
  {
    const Refuse refuse;
    sentence = device->open();
  }
  device->close();
  return sentence;
}

bool tells(const std::string& sentence) {
  return sentence.find("cannot start a thread") != std::string::npos;
}

/// A job of one step.
struct Double {
  using Request = int;
  using Answer = int;
  static constexpr const char* kOutOfMemory = "not enough memory";
  static double work(int request, Turn<int>& turn) {
    turn.hand_over(2 * request);
    return kNever;
  }
};

// A libusb whose transfers never end.
libusb_transfer* LIBUSB_CALL allocate(int) {
  return static_cast<libusb_transfer*>(std::calloc(1, sizeof(libusb_transfer)));
}
void LIBUSB_CALL release(libusb_transfer* transfer) { std::free(transfer); }
int LIBUSB_CALL submit(libusb_transfer*) { return LIBUSB_ERROR_NO_DEVICE; }
int LIBUSB_CALL cancel(libusb_transfer*) { return 0; }
int LIBUSB_CALL handle_events(libusb_context*, timeval*, int*) { return 0; }

} // namespace

TEST_CASE("the connection to Haply's service says that it has no thread") {
  setenv("TACTUS_HAPLY", "127.0.0.1:1", 1);
  CHECK(tells(open_refused("haply")));
}

TEST_CASE("a controller without a watchdog is not opened without the thread that replaces it") {
  setenv("TACTUS_LIBDHD", FAKE_DHD, 1);
  setenv("FAKE_DHD", "no watchdog", 1);
  CHECK(tells(open_refused("dhd")));
  CHECK(devices::find_driver("dhd")->list().at(0).state == "ready"); // closed again
  setenv("FAKE_DHD", "", 1);
  CHECK(open_refused("dhd") == ""); // needs none
}

TEST_CASE("the Falcon's stream says that it has no thread, whichever of the two is refused") {
  auto library = std::make_shared<devices::falcon::UsbLibrary>();
  library->alloc_transfer = allocate;
  library->free_transfer = release;
  library->submit_transfer = submit;
  library->cancel_transfer = cancel;
  library->handle_events_timeout_completed = handle_events;
  for (const int after : {0, 1}) {
    devices::falcon::Link link(library);
    devices::falcon::Stream stream(link);
    const Refuse refuse(after);
    CHECK(tells(stream.start()));
  }
}

TEST_CASE("a worker that gets no thread says why, and its owner does the same work") {
  Worker<Double> worker;
  for (const int request : {1, 2}) {
    const Refuse refuse;
    CHECK(worker.request(request) != "");
    CHECK(worker.is_here());
    worker.finish();
    CHECK(worker.take().answer == 2 * request);
  }
  CHECK(worker.request(3) == "");
  CHECK(!worker.is_here());
}
