/* A stand-in for Force Dimension's libdhd: one omega.3 whose handle, 0.1 kg with drag, advances by
 * 1 ms each time its position is asked for. The environment's FAKE_DHD chooses what goes wrong;
 * FAKE_DHD_LOADS counts how often it was loaded. */
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double position[3], velocity[3], force[3];
static double torque[3], grip, gap;
static int all_calls;
static int open_devices, force_on, cause, saturated, dead, calls, reset, expert, watchdog_steps;
static double max_force;
static unsigned buttons;
static int broken, open_calls, status_calls;

static int device_counts;
#if !defined(FAKE_DHD_INCOMPLETE) && !defined(FAKE_DRD)
__attribute__((constructor)) static void loaded(void) {
  const char* before = getenv("FAKE_DHD_LOADS");
  char text[16];
  snprintf(text, sizeof text, "%d", 1 + (before ? atoi(before) : 0));
  setenv("FAKE_DHD_LOADS", text, 1);
}
#endif

/* Leading itself: until the test or drdStop ends it. */
static atomic_int leading, arrived, interrupted, calls_meanwhile;

static int mode(const char* word) {
  const char* chosen = getenv("FAKE_DHD");
  return chosen && strcmp(chosen, word) == 0;
}

/* For the test. */
void fake_dhd_set_position(double x, double y, double z) {
  position[0] = x, position[1] = y, position[2] = z;
  memset(velocity, 0, sizeof velocity);
}
void fake_dhd_switch_off(int why) { force_on = 0, cause = why; }
void fake_dhd_switch_on(void) { force_on = 1, cause = 0; }
void fake_dhd_set(int is_dead, int is_saturated, int needs_reset, unsigned mask) {
  dead = is_dead, saturated = is_saturated, reset = needs_reset, buttons = mask;
}
void fake_dhd_force(double* out) { memcpy(out, force, sizeof force); }
/* torque and gripper force of the last call that had them; how many had */
int fake_dhd_wrist(double* out) {
  memcpy(out, torque, sizeof torque);
  out[3] = grip;
  return all_calls;
}
void fake_dhd_gap(double opening) { gap = opening; }
void fake_dhd_break(int is_broken) { broken = is_broken; }
/* calls of dhdOpenID and of dhdGetStatus so far */
void fake_dhd_calls(int* out) { out[0] = open_calls, out[1] = status_calls; }
/* open devices, force on, watchdog steps, expert mode */
void fake_dhd_counts(int* out) {
  out[0] = open_devices, out[1] = force_on, out[2] = watchdog_steps, out[3] = expert;
}
double fake_dhd_max_force(void) { return max_force; }

/* The interface. */
int dhdGetDeviceCount(void) { return ++device_counts, mode("none") ? 0 : 1; }
int fake_dhd_device_counts(void) { return device_counts; }
int dhdOpenID(char index) {
  ++open_calls;
  if ((index != 0 && !mode("many")) || mode("none"))
    return -1;
  dead = saturated = reset = cause = broken = 0;
  buttons = 0;
  memset(force, 0, sizeof force);
  memset(velocity, 0, sizeof velocity);
  memset(torque, 0, sizeof torque);
  grip = gap = 0;
  all_calls = 0;
  ++open_devices;
  return index;
}
int dhdOpenSerial(int serial) { return serial == 1234 ? dhdOpenID(0) : -1; }
int dhdClose(char id) {
  (void)id;
  --open_devices;
  return 0;
}
int dhdGetSystemType(char id) {
  (void)id;
  return mode("sigma.7") ? 104 : mode("omega.7") ? 35 : 33;
}
bool dhdHasWrist(char id) { return (void)id, mode("sigma.7") || mode("omega.7"); }
bool dhdHasActiveWrist(char id) { return (void)id, mode("sigma.7"); }
bool dhdHasGripper(char id) { return dhdHasWrist(id); }
bool dhdHasActiveGripper(char id) { return dhdHasWrist(id); }
int dhdGetGripperGap(double* out, char id) { return (void)id, *out = gap, 0; }
int dhdGetOrientationRad(double* a, double* b, double* c, char id) {
  return (void)id, *a = 0.1, *b = 0.2, *c = 0.3, 0;
}
int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty,
                                        double tz, double fg, char id) {
  (void)id;
  force[0] = fx, force[1] = fy, force[2] = fz;
  torque[0] = tx, torque[1] = ty, torque[2] = tz;
  grip = fg;
  ++all_calls;
  return dead ? -1 : 0;
}
const char* dhdGetSystemName(char id) {
  (void)id;
  return "omega.3";
}
int dhdGetSerialNumber(unsigned short* serial, char id) {
  (void)id;
  *serial = 1234;
  return 0;
}
int dhdGetPosition(double* x, double* y, double* z, char id) {
  int axis;
  (void)id;
  calls_meanwhile += leading;
  if (dead)
    return -1;
  for (axis = 0; axis < 3; ++axis) {
    velocity[axis] += 1e-3 * ((force_on ? force[axis] : 0) - velocity[axis]) / 0.1;
    position[axis] += 1e-3 * velocity[axis];
  }
  *x = position[0], *y = position[1], *z = position[2];
  return ++calls % 2; /* every other answer is the time guard's */
}
int dhdGetLinearVelocity(double* x, double* y, double* z, char id) {
  (void)id;
  *x = velocity[0], *y = velocity[1], *z = velocity[2];
  return 1;
}
#ifndef FAKE_DHD_INCOMPLETE
int dhdSetForce(double x, double y, double z, char id) {
  (void)id;
  force[0] = x, force[1] = y, force[2] = z;
  return dead ? -1 : saturated ? 2 : 0;
}
#endif
unsigned dhdGetButtonMask(char id) {
  (void)id;
  return buttons;
}
int dhdEnableForce(unsigned char on, char id) {
  (void)id;
  force_on = on;
  if (on)
    cause = 0;
  return 0;
}
int dhdGetStatus(int* status, char id) {
  (void)id;
  ++status_calls;
  memset(status, 0, 17 * sizeof *status);
  status[0] = status[1] = 1;
  status[3] = reset;
  status[5] = force_on;
  status[9] = broken;
  status[14] = cause;
  return 0;
}
int dhdReset(char id) {
  (void)id;
  reset = 1;
  return 0;
}
int dhdEnableExpertMode(void) { return expert = 1, 0; }
int dhdDisableExpertMode(void) { return expert = 0, 0; }
int dhdSetWatchdog(unsigned char steps, char id) {
  (void)id;
  if (!expert || mode("no watchdog"))
    return -1;
  watchdog_steps = steps;
  return 0;
}
int dhdSetMaxForce(double newton, char id) {
  (void)id;
  max_force = newton;
  return 0;
}
#ifdef FAKE_DRD
/* The robotic part. In mode "stuck" the way is not free; "slow" begins after 5 ms. */
int drdOpenID(char index) {
  leading = arrived = interrupted = calls_meanwhile = 0;
  return dhdOpenID(index);
}
int drdClose(char id) { return dhdClose(id); }
bool drdIsSupported(char id) { return (void)id, !mode("plain"); }
int drdAutoInit(char id) {
  (void)id;
  if (mode("slow"))
    nanosleep(&(struct timespec){0, 5000000}, NULL);
  leading = 1;
  while (!arrived && !interrupted)
    nanosleep(&(struct timespec){0, 1000000}, NULL);
  leading = 0;
  if (interrupted || mode("stuck"))
    return -1;
  reset = 0;
  return 0;
}
int drdStop(bool motors_on, char id) {
  (void)id;
  if (leading && !motors_on)
    interrupted = 1;
  return 0;
}
#endif
void fake_drd_end(void) { arrived = 1; }
/* leading, interrupted, positions asked for meanwhile */
void fake_drd_state(int* out) { out[0] = leading, out[1] = interrupted, out[2] = calls_meanwhile; }
const char* dhdErrorGetLastStr(void) { return dead ? "communication error" : "no device found"; }
