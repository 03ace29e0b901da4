/* The double of libdhd, with calls that hang on demand. */
#include "hang.h"
#define dhdOpenID plain_dhdOpenID
#define dhdClose plain_dhdClose
#define dhdGetPosition plain_dhdGetPosition
#define dhdSetForce plain_dhdSetForce
#define dhdGetDeviceCount plain_dhdGetDeviceCount
#include "tests/devices/force_dimension/fake_dhd.c"
#undef dhdOpenID
#undef dhdClose
#undef dhdGetPosition
#undef dhdSetForce
#undef dhdGetDeviceCount

int dhdOpenID(char index) { return may_hang("dhdOpenID"), plain_dhdOpenID(index); }
int dhdClose(char id) { return may_hang("dhdClose"), plain_dhdClose(id); }
int dhdGetPosition(double* x, double* y, double* z, char id) {
  return may_hang("dhdGetPosition"), plain_dhdGetPosition(x, y, z, id);
}
int dhdSetForce(double x, double y, double z, char id) {
  return may_hang("dhdSetForce"), plain_dhdSetForce(x, y, z, id);
}
int dhdGetDeviceCount(void) { return may_hang("dhdGetDeviceCount"), plain_dhdGetDeviceCount(); }
