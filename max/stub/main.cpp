#include "max/stub/host.hpp"

int main(int count, char** arguments) { return run_host(count, arguments); }
