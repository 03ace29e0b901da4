/* A stand-in for the vendor's libHD: one device with a mass of 0.1 kg and a scheduler thread of
 * 1 kHz. Force moves the mass, so a caller can see that force and position belong together.
 * The environment's FAKE_HD chooses what goes wrong, that a hand holds the mass ("held") or that
 * the scheduler has 25 Hz ("slow") or does not wait ("quick"). As the real driver, it opens no
 * device when it is loaded a second time; the environment's FAKE_HD_LOADS counts. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct {
  unsigned code;
  int internal;
  unsigned device;
} Error;
typedef unsigned (*Callback)(void*);

enum { kErrors = 16 };
static unsigned errors[kErrors];
static int error_count;
static double position[3] = {10, 20, -30}, velocity[3], force[3], last_force[3];
static double torque[3];
static int torques;
static _Atomic int enabled_force;
static int clamping, ramping, rate_hz, buttons, in_frame, open_devices, calibration_checks;
static int updates, openings, style_requested, calibration, styles = 2;
static unsigned long frames, forces_outside_frame;
static Callback callback;
static void* callback_context;
static int callback_done = 1;
static pthread_t thread;
static _Atomic int running;
static pthread_mutex_t guard = PTHREAD_MUTEX_INITIALIZER;

static int loads;
#ifndef FAKE_HD_INCOMPLETE
__attribute__((constructor)) static void loaded(void) {
  const char* before = getenv("FAKE_HD_LOADS");
  char text[16];
  loads = 1 + (before ? atoi(before) : 0);
  snprintf(text, sizeof text, "%d", loads);
  setenv("FAKE_HD_LOADS", text, 1);
}
#endif

static int mode(const char* word) {
  const char* chosen = getenv("FAKE_HD");
  return chosen && strcmp(chosen, word) == 0;
}

static void fail(unsigned code) {
  if (error_count < kErrors)
    errors[error_count++] = code;
}

/* For the test. */
void fake_hd_reset(void) {
  static const double start[3] = {10, 20, -30};
  pthread_mutex_lock(&guard);
  memcpy(position, start, sizeof position);
  memset(velocity, 0, sizeof velocity);
  memset(force, 0, sizeof force);
  memset(last_force, 0, sizeof last_force);
  memset(torque, 0, sizeof torque);
  torques = error_count = buttons = clamping = calibration_checks = updates = 0;
  frames = forces_outside_frame = 0;
  ramping = rate_hz = openings = calibration = 0;
  style_requested = -1;
  styles = 2;
  pthread_mutex_unlock(&guard);
}
/* Where the handle is, mm. */
void fake_hd_set_position(double x, double y, double z) {
  pthread_mutex_lock(&guard);
  position[0] = x, position[1] = y, position[2] = z;
  memset(velocity, 0, sizeof velocity);
  pthread_mutex_unlock(&guard);
}
/* What hdCheckCalibration answers from now on; 0: its usual answers. */
void fake_hd_calibration(int answer) {
  pthread_mutex_lock(&guard);
  calibration = answer;
  pthread_mutex_unlock(&guard);
}
/* The bits of HD_CALIBRATION_STYLE. As in the OpenHaptics API Reference ("Calibration Routines"),
 * hdUpdateCalibration takes one of them; more than one is an invalid value. */
void fake_hd_styles(int bits) {
  pthread_mutex_lock(&guard);
  styles = bits;
  pthread_mutex_unlock(&guard);
}
/* ramping, scheduler's rate, openings tried, calibrations looked at, style of the last update */
void fake_hd_more_counts(int out[5]) {
  pthread_mutex_lock(&guard);
  out[0] = ramping, out[1] = rate_hz, out[2] = openings, out[3] = calibration_checks;
  out[4] = style_requested;
  pthread_mutex_unlock(&guard);
}
void fake_hd_fail(unsigned code) {
  pthread_mutex_lock(&guard);
  fail(code);
  if (code == 0x0203) /* too fast: the device switches its force off */
    enabled_force = 0;
  pthread_mutex_unlock(&guard);
}
void fake_hd_press(int mask) {
  pthread_mutex_lock(&guard);
  buttons = mask;
  pthread_mutex_unlock(&guard);
}
/* frames, force calls outside frames, open devices, force enabled, clamping, calibrations */
void fake_hd_counts(unsigned long out[6]) {
  pthread_mutex_lock(&guard);
  out[0] = frames, out[1] = forces_outside_frame, out[2] = (unsigned long)open_devices;
  out[3] = (unsigned long)enabled_force, out[4] = (unsigned long)clamping;
  out[5] = (unsigned long)updates;
  pthread_mutex_unlock(&guard);
}
/* mN m, of the last call; how many there were */
int fake_hd_torque(double out[3]) {
  pthread_mutex_lock(&guard);
  memcpy(out, torque, sizeof torque);
  pthread_mutex_unlock(&guard);
  return torques;
}
void fake_hd_last_force(double out[3]) {
  pthread_mutex_lock(&guard);
  memcpy(out, last_force, sizeof last_force);
  pthread_mutex_unlock(&guard);
}

/* The interface. */
unsigned hdInitDevice(const char* name) {
  ++openings;
  if (mode("licence"))
    return fail(0x0600), 0xFFFFFFFFu;
  if (mode("dead") || loads > 1)
    return fail(0x0302), 0xFFFFFFFFu;
  if (mode("silent")) /* no handle, and no error either */
    return 0xFFFFFFFFu;
  if (mode("second") && (!name || strcmp(name, "Default PHANToM") != 0))
    return fail(0x0301), 0xFFFFFFFFu;
  if (mode("named") && (!name || strcmp(name, "Left Device") != 0))
    return fail(0x0301), 0xFFFFFFFFu;
  ++open_devices;
  return 7;
}
void hdDisableDevice(unsigned device) {
  (void)device;
  --open_devices;
}
void hdMakeCurrentDevice(unsigned device) { (void)device; }
void hdEnable(unsigned what) {
  if (what == 0x4000)
    enabled_force = 1;
  if (what == 0x4001)
    clamping = 1;
  if (what == 0x4002)
    ramping = 1;
}
void hdDisable(unsigned what) {
  if (what == 0x4000)
    enabled_force = 0;
}
void hdBeginFrame(unsigned device) {
  (void)device;
  in_frame = 1;
}
void hdEndFrame(unsigned device) {
  (void)device;
  in_frame = 0;
  pthread_mutex_lock(&guard);
  memcpy(last_force, force, sizeof force);
  ++frames;
  pthread_mutex_unlock(&guard);
}
void hdGetDoublev(unsigned what, double* out) {
  static const double box[6] = {-80, -60, -35, 80, 60, 35};
  switch (what) {
  case 0x2050:
    memcpy(out, position, sizeof position);
    break;
  case 0x2051:
    memcpy(out, velocity, sizeof velocity);
    break;
  case 0x2150:
    out[0] = 0.1, out[1] = 0.2, out[2] = 0.3;
    break;
  case 0x2551:
    memcpy(out, box, sizeof box);
    break;
  case 0x2603:
    mode("dumb") ? fail(0x0100) : (void)(*out = 3.4);
    break;
  case 0x2604:
    mode("dumb") ? fail(0x0100) : (void)(*out = 0.9);
    break;
  case 0x2602:
    mode("dumb") ? fail(0x0100) : (void)(*out = 0.5);
    break;
  default:
    fail(0x0100);
  }
}
void hdGetIntegerv(unsigned what, int* out) {
  pthread_mutex_lock(&guard);
  *out = what == 0x2000 ? buttons : what == 0x2554 ? (mode("6dof") ? 6 : 3) : styles;
  pthread_mutex_unlock(&guard);
}
#ifndef FAKE_HD_INCOMPLETE
void hdSetDoublev(unsigned what, const double* in) {
  if (what == 0x2701) {
    pthread_mutex_lock(&guard);
    forces_outside_frame += !in_frame;
    memcpy(torque, in, sizeof torque);
    ++torques;
    pthread_mutex_unlock(&guard);
  }
  if (what != 0x2700)
    return;
  if (!in_frame)
    ++forces_outside_frame;
  memcpy(force, in, sizeof force);
}
#endif
const char* hdGetString(unsigned what) {
  return what == 0x2501 ? "PHANTOM Omni" : what == 0x2503 ? "SensAble" : "F-0042";
}
Error hdGetError(void) {
  Error error = {0, 0, 0};
  pthread_mutex_lock(&guard);
  if (error_count > 0) {
    error.code = errors[0];
    memmove(errors, errors + 1, sizeof errors - sizeof errors[0]);
    --error_count;
  }
  pthread_mutex_unlock(&guard);
  return error;
}
unsigned hdCheckCalibration(void) {
  if (mode("inkwell"))
    return 0x5002;
  if (calibration)
    return ++calibration_checks, (unsigned)calibration;
  return calibration_checks++ == 0 ? 0x5001 : 0x5000;
}
void hdUpdateCalibration(unsigned style) {
  pthread_mutex_lock(&guard);
  style_requested = (int)style;
  if (style == 0 || (style & (style - 1)) != 0)
    fail(0x0101);
  else
    ++updates;
  pthread_mutex_unlock(&guard);
}

static void* scheduler(void* unused) {
  const double period = 1e-3, mass = 0.1, drag = 1.0;
  (void)unused;
  while (running) {
    const struct timespec pause = {0, mode("slow") ? 40000000 : mode("quick") ? 20000 : 1000000};
    int axis;
    nanosleep(&pause, NULL);
    if (!running)
      break;
    if (callback && !callback_done)
      callback_done = callback(callback_context) == 0;
    for (axis = 0; axis < 3; ++axis) {
      const double newton = enabled_force && !mode("held") ? force[axis] : 0;
      velocity[axis] += 1e3 * period * (newton - 1e-3 * drag * velocity[axis]) / mass;
      position[axis] += period * velocity[axis];
    }
  }
  return NULL;
}
void hdSetSchedulerRate(unsigned long hz) { rate_hz = (int)hz; }
unsigned long hdScheduleAsynchronous(Callback function, void* context, unsigned short priority) {
  (void)priority;
  callback = function, callback_context = context, callback_done = 0;
  return 1;
}
void hdUnschedule(unsigned long handle) {
  (void)handle;
  callback = NULL;
}
void hdStartScheduler(void) {
  if (mode("no scheduler")) {
    fail(0x0304);
    return;
  }
  running = 1;
  pthread_create(&thread, NULL, scheduler, NULL);
}
void hdStopScheduler(void) {
  if (!running)
    return;
  running = 0;
  pthread_join(thread, NULL);
}
