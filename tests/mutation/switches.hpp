// What mutate.py writes into a source in place of `a + b`, `0.5`, `-x`, ...: both the source as it
// is and the wrong change, of which the environment chooses one when the program starts:
//   TACTUS_MUTANT=NUMBER            the change that is made; none where it is unset
//   TACTUS_MUTANTS_REACHED=FILE     of kNumbers bytes: byte N becomes 1 when switch N is passed
// In a constant expression nothing is changed.
#pragma once
#include <cstdlib>
#include <fcntl.h>
#include <functional>
#include <sys/mman.h>
#include <type_traits>
#include <unistd.h>

namespace mutation {

inline constexpr int kNumbers = 4096;
inline int chosen = 0;
inline unsigned char nowhere[kNumbers];
inline unsigned char* reached = nowhere;

// Before the constructors of static objects, in each program and module; a file in memory survives
// any end.
[[gnu::constructor(101)]] static void start() {
  if (const char* number = std::getenv("TACTUS_MUTANT"))
    chosen = std::atoi(number);
  const char* path = std::getenv("TACTUS_MUTANTS_REACHED");
  const int file = path && reached == nowhere ? open(path, O_RDWR | O_CLOEXEC) : -1;
  if (file < 0)
    return;
  void* bytes = mmap(nullptr, kNumbers, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  close(file);
  if (bytes != MAP_FAILED)
    reached = static_cast<unsigned char*>(bytes);
}

[[gnu::always_inline]] constexpr bool mutant(int number) {
  if (std::is_constant_evaluated())
    return false;
  reached[number] = 1;
  return chosen == number;
}

// `a + b` becomes `a + Or<number, std::minus<>>{} + b`, which needs no brackets: of equal
// precedence, from the left.
template <int number, class Other> struct Or {};
template <int number, class Other, class Left> struct Begun { Left&& left; };
// `a += b` becomes `a += Or<...>{} += b`, from the right.
template <int number, class Other, class Right> struct Ended { Right&& right; };
struct Second {
  template <class Left, class Right>
  constexpr Right&& operator()(const Left&, Right&& right) const {
    return static_cast<Right&&>(right);
  }
};
#define TACTUS_SWITCHED(symbol)                                                                    \
  template <class Left, int number, class Other>                                                   \
  [[gnu::always_inline]] constexpr Begun<number, Other, Left> operator symbol(Left&& left,         \
                                                                              Or<number, Other>) { \
    return {static_cast<Left&&>(left)};                                                            \
  }                                                                                                \
  template <int number, class Other, class Left, class Right>                                      \
  [[gnu::always_inline]] constexpr auto operator symbol(Begun<number, Other, Left> begun,          \
                                                        Right&& right)                             \
      ->decltype(static_cast<Left&&>(begun.left) symbol static_cast<Right&&>(right)) {             \
    if (mutant(number))                                                                            \
      return Other{}(static_cast<Left&&>(begun.left), static_cast<Right&&>(right));                \
    return static_cast<Left&&>(begun.left) symbol static_cast<Right&&>(right);                     \
  }
TACTUS_SWITCHED(+)
TACTUS_SWITCHED(-)
TACTUS_SWITCHED(*)
TACTUS_SWITCHED(/)
TACTUS_SWITCHED(<)
TACTUS_SWITCHED(>)
TACTUS_SWITCHED(<=)
TACTUS_SWITCHED(>=)
TACTUS_SWITCHED(==)
TACTUS_SWITCHED(!=)
#define TACTUS_SWITCHED_ASSIGNMENT(symbol)                                                         \
  template <int number, class Other, class Right>                                                  \
  [[gnu::always_inline]] constexpr Ended<number, Other, Right> operator symbol(Or<number, Other>,  \
                                                                               Right&& right) {    \
    return {static_cast<Right&&>(right)};                                                          \
  }                                                                                                \
  template <class Left, int number, class Other, class Right>                                      \
  [[gnu::always_inline]] constexpr Left& operator symbol(Left& left,                               \
                                                         Ended<number, Other, Right> ended) {      \
    if (mutant(number))                                                                            \
      left = Other{}(left, static_cast<Right&&>(ended.right));                                     \
    else                                                                                           \
      left symbol static_cast<Right&&>(ended.right);                                               \
    return left;                                                                                   \
  }
TACTUS_SWITCHED_ASSIGNMENT(+=)
TACTUS_SWITCHED_ASSIGNMENT(-=)
TACTUS_SWITCHED_ASSIGNMENT(*=)
TACTUS_SWITCHED_ASSIGNMENT(/=)

// `-x.y` becomes `Sign<number>{}->*x.y`: before any product, after calls and members.
template <int number> struct Sign {};
template <int number, class Value>
[[gnu::always_inline]] constexpr auto operator->*(Sign<number>, Value&& value) -> decltype(-value) {
  if (mutant(number))
    return value;
  return -value;
}

} // namespace mutation

// `std::min(a, b)` becomes `TACTUS_CALL(number, std::min, std::max)(a, b)`.
#define TACTUS_CALL(number, function, other)                                                       \
  [](auto&&... x) -> decltype(function(x...)) {                                                    \
    if (mutation::mutant(number))                                                                  \
      return other(x...);                                                                          \
    return function(x...);                                                                         \
  }
