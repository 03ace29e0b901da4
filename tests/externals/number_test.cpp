// One rule for what is a number (core/text.hpp), whoever reads it.
#include "devices/driver.hpp"
#include "externals/phantom/words.hpp"
#include "files/mesh_file.hpp"
#include "files/path_file.hpp"
#include "files/recipe.hpp"
#include "net/fudi.hpp"

#include <doctest/doctest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

using namespace tactus;

namespace {

/// Whether a reader takes the word for a number.
using Reader = std::pair<const char*, std::function<bool(const std::string&)>>;

std::vector<Reader> readers() {
  std::vector<Reader> all{
      {"recipe",
       [](const std::string& word) {
         footstep::Recipe recipe;
         return files::read_recipe("[solid]\nfrequency " + word + "\n", recipe).empty();
       }},
      {"path",
       [](const std::string& word) { return !files::parse_path("0 0 0 " + word).rows.empty(); }},
      {"mesh",
       [](const std::string& word) {
         const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 " + word + "\nf 1 2 3\n";
         return files::read_mesh(text, files::MeshFormat::kObj).error.empty();
       }},
      {"scene",
       [](const std::string& word) {
         const auto words = phantom::words_of(word);
         return words.size() == 1 && !words[0].is_word;
       }},
      {"FUDI", [](const std::string& word) {
         std::string text = "bus topic " + word;
         net::Message message;
         bool found = false;
         return net::decode_fudi(text, message, found).empty() && message.size() == 1 &&
                message.number_at(0).has_value();
       }}};
  using Setting = std::pair<const char*, const char*>;
  for (const auto& [driver, setting] :
       {Setting{"hid", "speed"}, {"falcon", "gain"}, {"haply", "rate"}, {"evdev", "reach"}})
    if (const auto* found = devices::find_driver(driver); found && found->make())
      all.push_back({driver, [found, name = std::string(setting)](const std::string& word) {
                       const std::string words[] = {name, word};
                       return found->make()->configure(words).empty();
                     }});
  return all;
}

} // namespace

TEST_CASE("every reader of text takes the same words for numbers") {
  for (const auto& reader : readers()) {
    const auto& name = reader.first;
    const auto& reads = reader.second;
    CAPTURE(name);
    for (const char* word : {"1000", "+1000", "1e3", "1E+3", "1000.0", "1000."}) {
      CAPTURE(word);
      CHECK(reads(word));
    }
    for (const char* word : {"+-1000", "-+1000", "++1000", "1000x", "x1000", "0x3e8", "1e", "e3",
                             ".", "+", "-", "inf", "nan", "1e999"}) {
      CAPTURE(word);
      CHECK(!reads(word));
    }
  }
}
