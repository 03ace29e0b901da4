#include "devices/falcon/stream.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <deque>
#include <mutex>
#include <new>
#include <thread>
#include <vector>

using namespace tactus::devices::falcon;

namespace {

thread_local long allocations = 0;

/// libusb with a Falcon that answers each order at once, in this process: no bus and no kernel, so
/// that the thread sanitizer sees every access.
struct FakeUsb {
  std::mutex mutex;
  std::condition_variable work;
  std::deque<libusb_transfer*> in, out, done;
  Command last;
  std::vector<int> history; // of the first motor's commands, one a change
  long orders = 0;
  bool gone = false, stuck = false;
  bool mute = false;                    // orders are taken, answers wait
  long unanswered = 0;                  // orders taken while mute
  long failing_in = 0, failing_out = 0; // so many more transfers time out
  long allocated = 0, released = 0;

  void reset() {
    const std::scoped_lock lock(mutex);
    in.clear(), out.clear(), done.clear();
    last = {};
    history.clear();
    orders = 0;
    gone = stuck = mute = false;
    failing_in = failing_out = unanswered = allocated = released = 0;
  }
  /// What this says of it, while nobody else touches it; then the work goes on.
  template <class Act> auto locked(Act act) {
    const std::scoped_lock lock(mutex);
    work.notify_all();
    return act();
  }
  Values motors() {
    return locked([this] { return last.motors; });
  }
  static FakeUsb& instance() {
    static FakeUsb usb;
    return usb;
  }

  void finish(libusb_transfer* transfer, libusb_transfer_status status, int length) {
    transfer->status = status;
    transfer->actual_length = length;
    done.push_back(transfer);
  }

  // The device's turn: an order is decoded and answered with its motor values as encoders.
  void advance() {
    while (gone && !(in.empty() && out.empty())) {
      auto& queue = in.empty() ? out : in;
      finish(queue.front(), LIBUSB_TRANSFER_NO_DEVICE, 0);
      queue.pop_front();
    }
    for (auto* row : {&in, &out})
      for (long& left = row == &in ? failing_in : failing_out; left > 0 && !row->empty(); --left) {
        finish(row->front(), LIBUSB_TRANSFER_TIMED_OUT, 0);
        row->pop_front();
      }
    while (mute && !out.empty()) {
      ++unanswered;
      finish(out.front(), LIBUSB_TRANSFER_COMPLETED, out.front()->length);
      out.pop_front();
    }
    for (; !mute && unanswered > 0 && !in.empty(); --unanswered)
      response({});
    while (!stuck && !mute && !out.empty() && !in.empty()) {
      ResponseParser decoder;
      for (int i = 0; i < out.front()->length; ++i)
        decoder.process(out.front()->buffer[i]);
      last = {decoder.response().encoders, decoder.response().flags};
      ++orders;
      if (history.empty() || history.back() != last.motors[0])
        history.push_back(last.motors[0]);
      finish(out.front(), LIBUSB_TRANSFER_COMPLETED, out.front()->length);
      out.pop_front();
      response(last.motors);
    }
  }
  void response(const Values& encoders) {
    const Packet packet = encode(Response{encoders, 0x70});
    std::copy(packet.begin(), packet.end(), in.front()->buffer + kStatusBytes);
    finish(in.front(), LIBUSB_TRANSFER_COMPLETED, static_cast<int>(kStatusBytes + kPacketBytes));
    in.pop_front();
  }

  static int LIBUSB_CALL submit(libusb_transfer* transfer) {
    FakeUsb& usb = instance();
    const std::scoped_lock lock(usb.mutex);
    if (usb.gone)
      return LIBUSB_ERROR_NO_DEVICE;
    (transfer->endpoint & 0x80 ? usb.in : usb.out).push_back(transfer);
    usb.work.notify_all();
    return 0;
  }
  static int LIBUSB_CALL cancel(libusb_transfer* transfer) {
    FakeUsb& usb = instance();
    const std::scoped_lock lock(usb.mutex);
    for (auto* queue : {&usb.in, &usb.out})
      for (auto i = queue->begin(); i != queue->end(); ++i)
        if (*i == transfer) {
          queue->erase(i);
          usb.finish(transfer, LIBUSB_TRANSFER_CANCELLED, 0);
          return 0;
        }
    return LIBUSB_ERROR_NOT_FOUND;
  }
  static int LIBUSB_CALL handle_events(libusb_context*, timeval* most, int*) {
    FakeUsb& usb = instance();
    std::unique_lock lock(usb.mutex);
    usb.advance();
    if (usb.done.empty()) {
      usb.work.wait_for(lock, std::chrono::microseconds(most->tv_usec));
      usb.advance();
    }
    while (!usb.done.empty()) {
      libusb_transfer* transfer = usb.done.front();
      usb.done.pop_front();
      lock.unlock();
      transfer->callback(transfer);
      lock.lock();
    }
    return 0;
  }
  static libusb_transfer* LIBUSB_CALL allocate(int) {
    ++instance().allocated;
    return static_cast<libusb_transfer*>(std::calloc(1, sizeof(libusb_transfer)));
  }
  static void LIBUSB_CALL release(libusb_transfer* transfer) {
    ++instance().released;
    std::free(transfer);
  }
};

std::shared_ptr<UsbLibrary> fake_library() {
  FakeUsb::instance().reset();
  auto library = std::make_shared<UsbLibrary>();
  library->submit_transfer = FakeUsb::submit;
  library->cancel_transfer = FakeUsb::cancel;
  library->handle_events_timeout_completed = FakeUsb::handle_events;
  library->alloc_transfer = FakeUsb::allocate;
  library->free_transfer = FakeUsb::release;
  return library;
}

/// Motors that agree whatever the gain of a force that returns: each is rounded by itself.
Command command(int value) {
  const auto v = static_cast<std::int16_t>(value);
  return {{v, static_cast<std::int16_t>(-v), v}, Command::kGreen};
}

/// A servo that writes this order every millisecond until the device has it in full: the force of
/// one that begins to write rises over 0.1 s.
bool press(Stream& stream, const Command& wanted) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (std::chrono::steady_clock::now() < end) {
    stream.send(wanted);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (FakeUsb::instance().motors() == wanted.motors)
      return true;
  }
  return false;
}

template <class Condition> bool eventually(Condition condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!condition())
    if (std::chrono::steady_clock::now() > end)
      return false;
  return true;
}

} // namespace

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size ? size : 1))
    return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

TEST_CASE("orders go out and answers come in while the servo allocates nothing") {
  Link link(fake_library());
  Stream stream(link);
  REQUIRE(stream.start() == "");
  REQUIRE(press(stream, command(4000)));
  long received = 0, torn = 0;
  std::uint64_t number = 0;
  const std::uint64_t first_sends = stream.counts().sent + stream.counts().skipped;
  std::uint64_t sends = 0;
  const long before = allocations;
  const bool flows = eventually([&] {
    stream.send(command(static_cast<int>(++sends % 4000)));
    if (!stream.receive())
      return false;
    ++received;
    const Frame& frame = stream.latest();
    const auto& counts = frame.response.encoders;
    torn += counts[1] != -counts[0] || counts[2] != counts[0] || frame.number <= number;
    number = frame.number;
    return received == 5000;
  });
  CHECK(flows);
  CHECK(allocations == before);
  CHECK(torn == 0);
  CHECK(eventually([&] { // said again and again, since a stall of the machine ends the force
    stream.send(command(-5));
    ++sends;
    return stream.receive() && stream.latest().response.encoders[0] == -5;
  }));
  const Stream::Counts counts = stream.counts();
  CHECK(counts.broken == 0);
  CHECK(counts.failed == 0);
  CHECK(counts.sent + counts.skipped <= first_sends + sends + 1);
}

TEST_CASE("the newest order is the one that is sent last, and stopping sends none of force") {
  Link link(fake_library());
  FakeUsb& usb = FakeUsb::instance();
  {
    Stream stream(link);
    REQUIRE(stream.start() == "");
    REQUIRE(press(stream, command(4000)));
    usb.locked([&] { usb.stuck = true, usb.orders = 0; });
    for (int i = 1; i <= 100; ++i)
      stream.send(command(i));
    usb.locked([&] { usb.stuck = false; });
    CHECK(eventually([&] {
      return usb.locked(
          [&] { return std::count(usb.history.begin(), usb.history.end(), 100) > 0; });
    }));
    CHECK(usb.locked([&] { return usb.orders; }) <= 100);
  }
  CHECK(usb.last.motors == Values{});
  CHECK(usb.in.empty());
  CHECK(usb.out.empty());
}

TEST_CASE("a device that leaves is lost at once and can be let go") {
  FakeUsb& usb = FakeUsb::instance();
  for (const bool before_start : {false, true}) {
    Link link(fake_library());
    usb.gone = before_start;
    Stream stream(link);
    REQUIRE(stream.start() == "");
    stream.send(command(7));
    usb.locked([&] { usb.gone = true; });
    CHECK(eventually([&] { return stream.lost(); }));
    stream.send(command(8));
    stream.stop();
    stream.stop();
    CHECK(usb.allocated > 0);
    CHECK(usb.released == usb.allocated);
  }
}

TEST_CASE("fifty transfers that fail in a row are a lost line, fewer are counted and outlived") {
  for (const bool in : {true, false}) {
    CAPTURE(in);
    Link link(fake_library());
    FakeUsb& usb = FakeUsb::instance();
    Stream stream(link);
    REQUIRE(stream.start() == "");
    long& failing = in ? usb.failing_in : usb.failing_out;
    const auto fail = [&](long count) { // while the servo goes on
      usb.locked([&] { failing = count; });
      return eventually([&] {
        stream.send(command(4000));
        std::this_thread::sleep_for(std::chrono::microseconds(200));
        return usb.locked([&] { return failing == 0; }) || stream.lost();
      });
    };
    for (int row = 1; row <= 3; ++row) { // what goes well in between ends it
      REQUIRE(press(stream, command(1000 * row)));
      REQUIRE(fail(30));
      CHECK(eventually([&] { return stream.counts().failed == 30u * static_cast<unsigned>(row); }));
    }
    REQUIRE(press(stream, command(500)));
    CHECK_FALSE(stream.lost());
    static_cast<void>(fail(1000));
    CHECK(eventually([&] { return stream.lost(); }));
    // In and out are two transfers each, some of which may be under way.
    CHECK(stream.counts().failed >= 90 + 50);
    CHECK(stream.counts().failed <= 90 + 50 + 4);
  }
}

TEST_CASE("an order that waits for an answer goes out when the answer comes") {
  // Two are unanswered; the third must not wait for the next call of send(). Without an answer it
  // would go after 10 ms, and after 50 ms without a call as an order without force: a stall of the
  // machine of that length asks for another attempt.
  bool went = false;
  for (int attempt = 0; attempt < 200 && !went; ++attempt) {
    Link link(fake_library());
    FakeUsb& usb = FakeUsb::instance();
    Stream stream(link);
    REQUIRE(stream.start() == "");
    REQUIRE(press(stream, command(4000)));
    const auto taken = [&usb] { return usb.locked([&] { return usb.unanswered; }); };
    std::this_thread::sleep_for(std::chrono::milliseconds(2)); // what was under way is answered
    usb.locked([&] { usb.mute = true; });
    for (int i = 1; i <= 2; ++i) {
      stream.send(command(4000));
      eventually([&] { return taken() >= i; });
    }
    stream.send(command(3210));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const bool waited = taken() == 2;
    usb.locked([&] { usb.mute = false; });
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(30);
    while (waited && !went && std::chrono::steady_clock::now() < end)
      went = usb.motors() == command(3210).motors;
  }
  CHECK(went);
}

TEST_CASE("a device that takes no more orders does not keep the stream from stopping") {
  Link link(fake_library());
  FakeUsb& usb = FakeUsb::instance();
  Stream stream(link);
  REQUIRE(stream.start() == "");
  usb.locked([&] { usb.stuck = true; });
  for (int i = 0; i < 10; ++i)
    stream.send(command(i));
  stream.stop();
  CHECK(usb.released == usb.allocated);
}

TEST_CASE("a servo that stalls leaves no force, and its return is soft") {
  Link link(fake_library());
  FakeUsb& usb = FakeUsb::instance();
  Stream stream(link);
  REQUIRE(stream.start() == "");
  REQUIRE(press(stream, command(4000)));
  const auto stalled = std::chrono::steady_clock::now();
  REQUIRE(eventually([&] { return usb.motors() == Values{}; }));
  CHECK(std::chrono::steady_clock::now() - stalled > std::chrono::milliseconds(40));
  const long orders =
      usb.locked([&] { return usb.last.flags == Command::kGreen ? usb.orders : -1; });
  CHECK(orders > 0);
  // It is said again and again, in case an order was lost.
  CHECK(eventually([&] { return usb.locked([&] { return usb.orders >= orders + 5; }); }));
  usb.locked([&] { usb.history.clear(); });
  const auto returned = std::chrono::steady_clock::now();
  REQUIRE(press(stream, command(4000)));
  CHECK(std::chrono::steady_clock::now() - returned > std::chrono::milliseconds(95));
  const std::scoped_lock lock(usb.mutex);
  CHECK(usb.history.front() == 0);
  CHECK(std::max_element(usb.history.begin(), usb.history.end()) == usb.history.end() - 1);
}
