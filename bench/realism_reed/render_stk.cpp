// Plays STK's wind instruments for measurement: one note a line on standard input,
//   FILE Clarinet|Saxofony|Brass RATE SECONDS BREATH FREQUENCY_HZ
// FILE receives doubles.
#include <stk/Brass.h>
#include <stk/Clarinet.h>
#include <stk/Saxofony.h>
#include <stk/Stk.h>

#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

int main() {
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string file, name;
    double rate = 0, seconds = 0, breath = 0, frequency = 0;
    words >> file >> name >> rate >> seconds >> breath >> frequency;
    stk::Stk::setSampleRate(rate);
    std::unique_ptr<stk::Instrmnt> instrument;
    if (name == "Clarinet")
      instrument = std::make_unique<stk::Clarinet>(20);
    else if (name == "Saxofony")
      instrument = std::make_unique<stk::Saxofony>(20);
    else if (name == "Brass")
      instrument = std::make_unique<stk::Brass>(20);
    if (!instrument || !words) {
      std::fprintf(stderr, "render_stk: cannot play: %s\n", line.c_str());
      return 1;
    }
    instrument->controlChange(1, 0); // vibrato off; Brass takes it as vibrato gain as well
    instrument->noteOn(frequency, breath);
    std::vector<double> sound(static_cast<std::size_t>(rate * seconds));
    for (double& sample : sound)
      sample = instrument->tick();
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(sound.data()),
              static_cast<std::streamsize>(sound.size() * sizeof(double)));
  }
}
