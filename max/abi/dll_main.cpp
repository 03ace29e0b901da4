#include <windows.h>

// With the vendor's import libraries only: theirs exports a DllMain, which a module without its own
// runs.
extern "C" BOOL WINAPI DllMain(HINSTANCE, DWORD, LPVOID);
extern "C" BOOL WINAPI DllMain(HINSTANCE, DWORD, LPVOID) { return TRUE; }
