"""Every source includes, itself or by the project's own headers, a header that declares each name of
std it uses. The build reads the standard library's headers once for all files
(cmake/PrecompiledHeaders.cmake), so the compiler does not notice one that is missing.

    check_includes.py ROOT FOLDER...     the C++ files below these folders of the checkout count
"""
import functools
import pathlib
import re
import sys

NAMES = """
algorithm: adjacent_find all_of any_of binary_search clamp copy copy_if copy_n count count_if equal fill fill_n find
  find_if generate is_sorted lower_bound max max_element merge min min_element minmax minmax_element mismatch none_of
  nth_element partial_sort remove remove_if replace replace_if reverse rotate search set_intersection shuffle sort
  stable_partition stable_sort transform unique upper_bound
atomic: atomic atomic_thread_fence memory_order_acq_rel memory_order_acquire memory_order_relaxed memory_order_release
  memory_order_seq_cst
bit: bit_cast bit_ceil bit_floor countl_zero countr_zero endian popcount rotl rotr
cctype: isalnum isalpha isdigit isspace tolower toupper
charconv: chars_format from_chars to_chars
cmath: abs acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh cyl_bessel_j erf erfc exp exp2 expm1
  fabs floor fma fmax fmin fmod fpclassify hypot ilogb isfinite isinf isnan ldexp legendre llround log log10 log1p log2
  lround nan nextafter pow remainder rint round signbit sin sinh sph_bessel sph_legendre sph_neumann sqrt tan tanh tgamma
  trunc
complex: complex abs arg conj exp norm polar pow sqrt
concepts: floating_point integral same_as
condition_variable: condition_variable condition_variable_any
csignal: raise signal
cstdarg: va_list
cstddef: byte max_align_t nullptr_t ptrdiff_t size_t to_integer
cstdint: int16_t int32_t int64_t int8_t intptr_t uint16_t uint32_t uint64_t uint8_t uintptr_t
cstdio: FILE fclose ferror fflush fgets fopen fprintf fputc fputs fread fscanf fwrite getchar perror printf putchar
  puts remove rename size_t snprintf sscanf vsnprintf
cstdlib: abort abs aligned_alloc atexit atof atoi atol calloc exit free getenv malloc realloc size_t strtod strtol
  strtoul strtoull system
cstring: memcmp memcpy memmove memset size_t strcmp strerror strlen strncmp
ctime: clock clock_t gmtime size_t strftime time time_t tm
cwchar: size_t swprintf
exception: exception exception_ptr current_exception
fstream: ifstream ofstream
functional: function greater hash less negate plus reference_wrapper ref cref
future: async future future_status launch promise
iomanip: setprecision
ios: ios streamoff streamsize
iostream: cerr cin cout
iterator: istream_iterator back_inserter distance istreambuf_iterator next prev
limits: numeric_limits
map: map multimap
memory: make_shared make_unique shared_ptr static_pointer_cast unique_ptr weak_ptr
mutex: call_once lock_guard mutex recursive_mutex once_flag scoped_lock try_to_lock unique_lock
new: bad_alloc set_new_handler
numeric: accumulate inner_product iota midpoint reduce
optional: nullopt optional
queue: priority_queue queue
random: mt19937 mt19937_64 normal_distribution random_device uniform_int_distribution uniform_real_distribution
ratio: micro milli nano
regex: regex regex_search smatch sregex_iterator
set: multiset set
span: as_bytes span
sstream: istringstream ostringstream stringstream
stdexcept: invalid_argument length_error logic_error out_of_range runtime_error
stop_token: stop_token stop_source
string: getline stod stoi stol stoul stoull string to_string u8string wstring
string_view: string_view wstring_view
system_error: errc error_code system_error generic_category system_category
thread: jthread this_thread thread
tuple: tie tuple tuple_size_v
type_traits: conditional_t decay_t enable_if_t false_type is_constant_evaluated is_floating_point_v is_same_v is_signed_v is_trivially_copyable_v remove_cvref_t
  remove_reference_t true_type
unordered_map: unordered_map unordered_multimap
utility: as_const exchange forward in_place index_sequence make_index_sequence make_pair move pair swap tuple_size_v
variant: get_if holds_alternative variant visit
of their name alone: array bitset chrono deque filesystem initializer_list istream list numbers ostream vector
"""
CONTAINERS = ("array", "deque", "map", "set", "span", "string", "string_view", "unordered_map", "vector")
# What the standard lets a header bring: [utility.syn], [container], [string.syn], [thread.syn] ...
ALSO = {"begin": (*CONTAINERS, "iterator"), "end": (*CONTAINERS, "iterator"), "size": (*CONTAINERS, "iterator"),
        "erase": ("deque", "string", "vector"), "erase_if": ("deque", "map", "set", "string", "vector"),
        "get": ("array", "tuple", "utility", "variant"),
        "initializer_list": ("utility", "algorithm", *CONTAINERS), "stop_token": ("thread",),
        "tuple_size_v": ("array",), "pair": ("map", "unordered_map"), "getline": ("istream",),
        "istream": ("fstream", "sstream", "iostream"), "ostream": ("fstream", "sstream", "iostream"),
        "ios": ("fstream", "sstream", "iostream", "istream", "ostream"),
        "streamsize": ("fstream", "sstream", "iostream", "istream", "ostream"),
        "streamoff": ("fstream", "sstream", "iostream", "istream", "ostream"),
        "nano": ("chrono",), "micro": ("chrono",), "milli": ("chrono",),
        # Named by what these headers declare, so every library brings them.
        "string_view": ("string",), "errc": ("charconv",), "error_code": ("filesystem",),
        "exception": ("stdexcept",), "tuple": ("map",),
        **{name: (*CONTAINERS, "algorithm", "functional", "memory", "optional", "variant")
           for name in ("move", "pair", "swap", "size_t", "ptrdiff_t")}}


def declaring():
    table = {name: set(headers) for name, headers in ALSO.items()}
    for row in NAMES.strip().replace("\n ", "").splitlines():
        header, names = row.split(":")
        for name in names.split():
            table.setdefault(name, set()).add(name if header == "of their name alone" else header)
    return table


def stripped(text):
    """Without comments and the insides of literals."""
    return re.sub(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"',
                  lambda m: '""' if m[0][0] in 'R"' else " ", text, flags=re.S)


def check(root, folders):
    table = declaring()

    @functools.cache
    def headers(path):
        """(standard headers, project headers) that a file itself includes."""
        text = path.read_text()
        own = []
        for name in re.findall(r'^\s*#\s*include\s+"([^"]+)"', text, re.M):
            own += [p.resolve() for p in (path.parent / name, root / name) if p.is_file()][:1]
        return set(re.findall(r"^\s*#\s*include\s+<([^>]+)>", text, re.M)), own

    def reached(path):
        seen, found, waiting = {path}, set(), [path]
        while waiting:
            standard, own = headers(waiting.pop())
            found |= standard
            waiting += [p for p in own if p not in seen]
            seen.update(own)
        return found

    wrong = []
    for path in sorted(p for f in folders for s in ("*.cpp", "*.hpp") for p in (root / f).rglob(s)):
        found = reached(path.resolve())
        for name in sorted(set(re.findall(r"(?<![\w:])std::(\w+)", stripped(path.read_text())))):
            if name not in table:
                wrong.append(f"{path.relative_to(root)}: std::{name} is not in the table of {pathlib.Path(__file__).name}")
            elif not table[name] & found:
                wrong.append(f"{path.relative_to(root)}: std::{name} without "
                             + " or ".join(f"<{h}>" for h in sorted(table[name])))
    return wrong


def main(root, *folders):
    wrong = check(pathlib.Path(root).resolve(), folders)
    if wrong:
        sys.exit("\n".join(wrong))


if __name__ == "__main__":
    main(*sys.argv[1:])
