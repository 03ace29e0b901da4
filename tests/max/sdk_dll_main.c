/* In place of the DllMain in the vendor's MaxAudio.lib: a module that runs this one ends its host.
 */
__declspec(dllimport) __declspec(noreturn) void ExitProcess(unsigned int status);
int DllMain(void* module, unsigned int reason, void* reserved);

int DllMain(void* module, unsigned int reason, void* reserved) {
  (void)module;
  (void)reason;
  (void)reserved;
  ExitProcess(97);
}
