extern "C" int run_host();

int main() { return run_host(); }
