/* The double of libHD, with calls that hang on demand and errors on demand. */
#include "hang.h"
#define hdInitDevice plain_hdInitDevice
#define hdDisableDevice plain_hdDisableDevice
#define hdStartScheduler plain_hdStartScheduler
#define hdStopScheduler plain_hdStopScheduler
#define hdEndFrame plain_hdEndFrame
#include "tests/devices/openhaptics/fake_hd.c"
#undef hdInitDevice
#undef hdDisableDevice
#undef hdStartScheduler
#undef hdStopScheduler
#undef hdEndFrame

unsigned hdInitDevice(const char* name) {
  return may_hang("hdInitDevice"), plain_hdInitDevice(name);
}
void hdDisableDevice(unsigned device) {
  may_hang("hdDisableDevice"), plain_hdDisableDevice(device);
}
void hdStartScheduler(void) { may_hang("hdStartScheduler"), plain_hdStartScheduler(); }
void hdStopScheduler(void) { may_hang("hdStopScheduler"), plain_hdStopScheduler(); }
void hdEndFrame(unsigned device) {
  static int fast;
  may_hang("hdEndFrame");
  if (asked_for("warm"))
    fake_hd_fail(0x0200); /* in each frame, as the device does */
  if (asked_for("fast") && !fast)
    fake_hd_fail(0x0203);
  fast = asked_for("fast");
  plain_hdEndFrame(device);
}
