#include "externals/child_process.hpp"
#include "files/system_folders.hpp"
#include "files/utf8_path.hpp"

#include <chrono>
#include <cstdio>
#include <string>

#include <fcntl.h>
#ifdef _WIN32
#include <io.h>
#else
#include <unistd.h>
#endif

// A program and its child, which is the same program: what both systems' halves must do.

#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

using namespace tactus;

namespace {

std::string own_path;

/// Answers every byte of stdin, then says its arguments and what else it has open on stderr.
int be_child(int count, char** words) {
#ifdef _WIN32
  _setmode(_fileno(stdin), _O_BINARY);
  _setmode(_fileno(stdout), _O_BINARY);
#endif
  for (int c; (c = std::getchar()) != EOF && c != '!';)
    std::putchar(c);
  std::fflush(stdout);
  for (int i = 2; i < count; ++i)
    std::fprintf(stderr, "[%s]", words[i]);
#ifndef _WIN32
  for (int number = STDERR_FILENO + 1; number < 256; ++number)
    if (::fcntl(number, F_GETFD) >= 0)
      std::fprintf(stderr, "[descriptor %d]", number);
#endif
  std::fprintf(stderr, "\n");
  return 3;
}

} // namespace

TEST_CASE("a child answers a megabyte, ends, and has its words and none of our files") {
#ifndef _WIN32
  const int ours = ::dup(STDERR_FILENO); // not closed on exec
#endif
  std::string refusal;
  const std::vector<std::string> words{own_path, "child", "two words", "a\"b\\", ""};
  auto child = ChildProcess::start(words, refusal);
  REQUIRE_MESSAGE(child, refusal);
  std::vector<std::byte> sent(1 << 20), back;
  for (std::size_t i = 0; i < sent.size(); ++i)
    sent[i] = static_cast<std::byte>(i % 251 == '!' ? 0 : i % 251);
  sent.push_back(std::byte{'!'});
  std::size_t done = 0;
  bool open = true;
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (open && std::chrono::steady_clock::now() < until) {
    done += child->send(std::span(sent).subspan(done));
    open = child->receive(back, 1 << 16);
    child->wait(1e-3);
  }
  CHECK_FALSE(open);
  sent.pop_back();
  CHECK(back == sent);
  CHECK(child->end(1) == "[two words][a\"b\\][]");
#ifndef _WIN32
  ::close(ours);
#endif
}

TEST_CASE("a child that waits is killed, and one that is not there is refused") {
  std::string refusal;
  auto child = ChildProcess::start({own_path, "child"}, refusal);
  REQUIRE(child);
  std::vector<std::byte> bytes;
  CHECK(child->receive(bytes, 100));
  const auto begun = std::chrono::steady_clock::now();
  child->wait(0.05);
  CHECK(std::chrono::steady_clock::now() - begun >= std::chrono::milliseconds(40));
  child.reset();
  CHECK(std::chrono::steady_clock::now() - begun < std::chrono::seconds(10));
  CHECK(ChildProcess::start({own_path + "-nowhere"}, refusal) == nullptr);
  CHECK(refusal.find("cannot start") != std::string::npos);
  CHECK(find_program("no-such-program", "").empty());
  CHECK(find_program("unused", own_path) == own_path);
}

int main(int count, char** words) {
  if (count > 1 && std::string(words[1]) == "child")
    return be_child(count, words);
  own_path = to_utf8(std::filesystem::absolute(utf8_path(words[0])));
  return doctest::Context(count, words).run();
}
