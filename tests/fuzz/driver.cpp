// Runs a decoder on the files of a corpus, then on inputs made from them by random changes.
//   NAME_fuzz CORPUS INPUTS [SEED]
// A crash, a sanitizer's report or check() ends the run; the input is then in last_input.bin.
#include "tests/fuzz/fuzz.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

namespace {

using Input = std::vector<std::uint8_t>;

Input last;

void run(const Input& input) {
  last = input;
  tactus::fuzz::decode(input);
}

class Mutator {
public:
  Mutator(std::vector<Input> corpus, unsigned seed) : corpus_(std::move(corpus)), random_(seed) {}

  Input next() {
    Input input = corpus_[index(corpus_.size())];
    for (std::size_t changes = 1 + index(6); changes > 0; --changes)
      change(input);
    return input;
  }

private:
  std::size_t index(std::size_t size) {
    return std::uniform_int_distribution<std::size_t>(0, size - 1)(random_);
  }
  std::uint8_t byte() {
    constexpr std::uint8_t kBoundaryBytes[] = {0,   1,   4,   0x7F, 0x80, 0xC0, 0xDB, 0xDC, 0xDD,
                                               255, ';', ',', '\\', ' ',  '\n', '/',  '$',  '-'};
    return index(2) ? static_cast<std::uint8_t>(index(256))
                    : kBoundaryBytes[index(std::size(kBoundaryBytes))];
  }
  void change(Input& input) {
    const auto at = static_cast<std::ptrdiff_t>(input.empty() ? 0 : index(input.size() + 1));
    switch (index(7)) {
    case 0: // cut
      input.resize(static_cast<std::size_t>(at));
      break;
    case 1: // a byte more
      input.insert(input.begin() + at, byte());
      break;
    case 2: { // another input's piece
      const Input& other = corpus_[index(corpus_.size())];
      if (!other.empty()) {
        const auto from = static_cast<std::ptrdiff_t>(index(other.size()));
        input.insert(input.begin() + at, other.begin() + from, other.end());
      }
      break;
    }
    case 3: // a run of one byte
      input.insert(input.begin() + at, index(40) == 0 ? 70000 : 1 + index(16), byte());
      break;
    case 4: // random bytes behind
      for (std::size_t n = index(24); n > 0; --n)
        input.push_back(byte());
      break;
    default:
      if (!input.empty())
        input[index(input.size())] = byte();
    }
  }

  std::vector<Input> corpus_;
  std::mt19937 random_;
};

} // namespace

void tactus::fuzz::check(bool holds, const char* what) {
  if (holds)
    return;
  std::ofstream("last_input.bin", std::ios::binary)
      .write(reinterpret_cast<const char*>(last.data()), static_cast<std::streamsize>(last.size()));
  std::fprintf(stderr, "fuzz: %s; the input is in last_input.bin\n", what);
  std::abort();
}

int main(int count, char** words) {
  if (count < 3)
    return std::fprintf(stderr, "usage: %s CORPUS INPUTS [SEED]\n", words[0]), 2;
  std::vector<Input> corpus;
  for (const auto& entry : std::filesystem::directory_iterator(words[1])) {
    std::ifstream file(entry.path(), std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  if (corpus.empty())
    return std::fprintf(stderr, "fuzz: %s holds no files\n", words[1]), 2;
  std::sort(corpus.begin(), corpus.end()); // whatever order the folder has
  for (const Input& input : corpus)
    run(input);
  const long inputs = std::atol(words[2]);
  Mutator mutator(corpus, count > 3 ? static_cast<unsigned>(std::atol(words[3])) : 1u);
  for (long i = 0; i < inputs; ++i)
    run(mutator.next());
  std::printf("%zu files and %ld changed inputs decoded\n", corpus.size(), inputs);
  return 0;
}
