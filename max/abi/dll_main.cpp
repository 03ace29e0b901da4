#include <windows.h>

// Needed only with the vendor's import libraries: they export a DllMain, which a module without its
// own DllMain would run.
extern "C" BOOL WINAPI DllMain(HINSTANCE, DWORD, LPVOID);
extern "C" BOOL WINAPI DllMain(HINSTANCE, DWORD, LPVOID) { return TRUE; }
