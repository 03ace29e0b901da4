// joystick_double: runs a program in a world where a joystick with force feedback is plugged in.
//
//   umockdev-wrapper joystick_double PROGRAM ARGUMENTS...
//
// Commands: axis CODE VALUE, key CODE VALUE, drop X (events were lost while it moved there), lift
// CODE (a key goes up unheard, for the next drop), half CODE VALUE (an event without its report),
// range MINIMUM MAXIMUM (of the axes), axes COUNT (of X, Y, Z; 3 at first), fail ERRNO (of the next
// force orders; 0 ends it), state. Two more devices answer nothing: they are no joysticks.
// An effect lasts its replay.length from its start; one of length 0, by the temper of the driver,
//   0  for ever, as with memoryless devices (drivers/input/ff-memless.c);
//   1  not at all: as no time sent to a PID device (drivers/hid/usbhid/hid-pidff.c before it had
//      PID_INFINITE, "Convert infinite length from Linux API (0) to PID standard");
//   2  65.535 s: as 0xffff sent to a PID device that does not take it for infinity;
//   3  for ever, but a new level counts with the next start only (said of some; no source known).
// State: `feltN` is the level that is felt now with temper N, `starts` how often the effect was
// started, `lapses` how often it had come to its end before with any temper.
#include "tests/devices/mock/child.hpp"

#include <umockdev.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <map>
#include <mutex>
#include <sstream>

#include <linux/input.h>
#include <unistd.h>

namespace {

const char* const kNode = "/dev/input/event3";

// What the kernel tells of an input device; `further`: attributes of its own.
std::string record(const std::string& port, int input, int event, const std::string& name,
                   const std::string& further) {
  const std::string of_input = "input" + std::to_string(input),
                    node = "input/event" + std::to_string(event),
                    path = "P: /devices/" + port + "/input/" + of_input;
  return path + "\nE: SUBSYSTEM=input\nA: name=" + name + "\\n\n" + further + "\n" + path +
         "/event" + std::to_string(event) + "\nN: " + node + "\nE: DEVNAME=/dev/" + node +
         "\nE: SUBSYSTEM=input\nE: MAJOR=13\nE: MINOR=" + std::to_string(64 + event) +
         "\nL: device=../../" + of_input + "\n\n";
}

std::string records() {
  // Two forces that it knows: constant, bit 0x52; gain, bit 0x60.
  const std::string forces = "A: capabilities/ff=100040000 0\\n\n", usb = "pci0000:00/usb1/";
  return record(usb + "1-2/1-2:1.0", 5, 3, "Double Stick",
                "A: uniq=STICK7\\n\n" + forces + "A: capabilities/abs=7\\n\n") +
         record("platform/keyboard", 6, 4, "Keyboard", "A: capabilities/ff=0\\n\n") +
         record(usb + "1-4/1-4:1.0", 12, 12, "Silent Wheel", forces) +
         record(usb + "1-5/1-5:1.0", 21, 21, "Silent Stick", forces);
}

constexpr int kKeys[] = {BTN_MISC, BTN_TRIGGER, BTN_THUMB, BTN_GAMEPAD, KEY_MAX - 7};

class Stick {
public:
  std::string command(const std::string& line, int master) {
    const std::scoped_lock lock(mutex_);
    std::istringstream words(line);
    std::string name;
    int code = 0, value = 0;
    words >> name >> code >> value;
    if (name == "axis") {
      axes_[code] = value;
      feed(master, EV_ABS, code, value);
      feed(master, EV_SYN, SYN_REPORT, 0);
    } else if (name == "half") {
      feed(master, EV_ABS, code, value);
    } else if (name == "range") {
      minimum_ = code, maximum_ = value;
    } else if (name == "axes") {
      axis_count_ = code;
    } else if (name == "lift") {
      keys_[code] = 0;
    } else if (name == "key") {
      keys_[code] = value;
      feed(master, EV_KEY, code, value);
      feed(master, EV_SYN, SYN_REPORT, 0);
    } else if (name == "drop") { // it moves, and nobody hears of it
      axes_[ABS_X] = code;
      feed(master, EV_SYN, SYN_DROPPED, 0);
      feed(master, EV_ABS, ABS_X, -30000);
      feed(master, EV_SYN, SYN_REPORT, 0);
    } else if (name == "fail") {
      failure_ = code;
    } else if (name == "state") {
      char text[300];
      std::snprintf(text, sizeof text,
                    "level=%d direction=%d playing=%d effects=%d uploads=%d gain=%d centre=%d "
                    "refusals=%d length=%d starts=%d lapses=%d felt0=%d felt1=%d "
                    "felt2=%d felt3=%d",
                    level_, direction_, playing_, effects_, uploads_, gain_, centre_, refusals_,
                    length_, starts_, lapses_, felt(0), felt(1), felt(2), felt(3));
      return text;
    } else {
      return "?";
    }
    return "ok";
  }

  gboolean ioctl(UMockdevIoctlClient* client) {
    const std::scoped_lock lock(mutex_);
    const auto request = static_cast<unsigned long>(umockdev_ioctl_client_get_request(client));
    const auto size = _IOC_SIZE(request);
    UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);
    if (request == EVIOCRMFF) {
      --effects_;
      level_ = playing_ = 0;
      return done(client, 0, 0);
    }
    UMockdevIoctlData* data = umockdev_ioctl_data_resolve(argument, 0, size, nullptr);
    if (!data)
      return done(client, -1, EIO);
    if (request == EVIOCSFF) {
      refusals_ += failure_ != 0;
      if (failure_ != 0)
        return done(client, -1, failure_);
      ff_effect effect;
      std::memcpy(&effect, data->data, sizeof effect);
      if (effect.type != FF_CONSTANT)
        return done(client, -1, EINVAL);
      if (effect.id < 0) {
        effect.id = 4;
        ++effects_;
        std::memcpy(data->data, &effect, sizeof effect);
      }
      ++uploads_;
      length_ = effect.replay.length;
      level_ = effect.u.constant.level;
      direction_ = effect.direction;
      return done(client, 0, 0);
    }
    for (const int code : {ABS_X, ABS_Y, ABS_Z})
      if (request == EVIOCGABS(static_cast<unsigned>(code))) {
        if (code >= axis_count_) // X, Y, Z are 0, 1, 2
          return done(client, -1, EINVAL);
        input_absinfo range{};
        range.value = axes_[code];
        range.minimum = minimum_;
        range.maximum = maximum_;
        std::memcpy(data->data, &range, sizeof range);
        return done(client, 0, 0);
      }
    const bool which = request == EVIOCGBIT(EV_KEY, size);
    if (which || request == EVIOCGKEY(size)) {
      std::memset(data->data, 0, size);
      for (const int key : kKeys)
        if ((which || keys_[key]) && key / 8 < static_cast<int>(size))
          data->data[key / 8] = static_cast<unsigned char>(data->data[key / 8] | 1u << (key % 8));
      return done(client, static_cast<long>(size), 0);
    }
    return done(client, -1, ENOTTY);
  }

  gboolean write(UMockdevIoctlClient* client) {
    const std::scoped_lock lock(mutex_);
    UMockdevIoctlData* data = umockdev_ioctl_client_get_arg(client);
    input_event event{};
    std::memcpy(&event, data->data,
                std::min(sizeof event, static_cast<std::size_t>(data->data_len)));
    if (event.type == EV_FF && event.code == FF_GAIN)
      gain_ = event.value;
    else if (event.type == EV_FF && event.code == FF_AUTOCENTER)
      centre_ = event.value;
    else if (event.type == EV_FF && event.code == 4) {
      lapses_ += playing_ && !(plays(0) && plays(1) && plays(2));
      ++starts_;
      playing_ = event.value;
      started_ = Clock::now();
      started_level_ = level_;
    }
    return done(client, static_cast<long>(data->data_len), 0);
  }

private:
  using Clock = std::chrono::steady_clock;
  [[nodiscard]] int felt(int temper) const {
    return plays(temper) ? (temper == 3 ? started_level_ : level_) : 0;
  }
  [[nodiscard]] bool plays(int temper) const {
    const int length_ms = length_ ? length_ : temper == 1 ? 0 : temper == 2 ? 65535 : 1 << 30;
    return playing_ && Clock::now() - started_ < std::chrono::milliseconds(length_ms);
  }
  static gboolean done(UMockdevIoctlClient* client, long result, int error) {
    umockdev_ioctl_client_complete(client, result, error);
    return TRUE;
  }
  static void feed(int master, int type, int code, int value) {
    input_event event{};
    event.type = static_cast<unsigned short>(type);
    event.code = static_cast<unsigned short>(code);
    event.value = value;
    if (::write(master, &event, sizeof event) < 0)
      std::perror("joystick_double");
  }

  std::mutex mutex_;
  std::map<int, int> axes_, keys_;
  int minimum_ = -32768, maximum_ = 32767, axis_count_ = 3, centre_ = -1, refusals_ = 0;
  int length_ = -1, started_level_ = 0, starts_ = 0, lapses_ = 0;
  Clock::time_point started_{};
  int level_ = 0, direction_ = 0, playing_ = 0, effects_ = 0, uploads_ = 0, gain_ = 0;
  int failure_ = 0;
};

} // namespace

int main(int count, char** words) {
  if (count < 2)
    return std::fputs("umockdev-wrapper joystick_double PROGRAM ARGUMENTS...\n", stderr), 2;
  UMockdevTestbed* bed = tactus::mock::new_test_bed();
  GError* error = nullptr;
  if (!umockdev_testbed_add_from_string(bed, records().c_str(), &error)) {
    std::fprintf(stderr, "joystick_double: %s\n", error->message);
    return 2;
  }
  Stick stick;
  UMockdevIoctlBase* handler = umockdev_ioctl_base_new();
  g_signal_connect(handler, "handle-ioctl",
                   G_CALLBACK(+[](UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
                     return static_cast<Stick*>(self)->ioctl(client);
                   }),
                   &stick);
  g_signal_connect(handler, "handle-write",
                   G_CALLBACK(+[](UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
                     return static_cast<Stick*>(self)->write(client);
                   }),
                   &stick);
  if (!umockdev_testbed_attach_ioctl(bed, kNode, handler, &error)) {
    std::fprintf(stderr, "joystick_double: %s\n", error->message);
    return 2;
  }
  const int master = umockdev_testbed_get_dev_fd(bed, kNode);
  const int status = tactus::mock::run_child(
      words + 1,
      [&](const std::string& line) -> std::string { return stick.command(line, master); }, [] {});
  umockdev_testbed_detach_ioctl(bed, kNode, nullptr);
  g_object_unref(handler);
  g_object_unref(bed);
  return status;
}
