// buffer~ contents by name, and references to them.
#include "max/stub/audio.hpp"

#include <cstring>
#include <memory>

/// One buffer~: frames by channels, interleaved, at the end of memory that may not be passed.
struct t_buffer_obj : tactus::stub::Record {
  static constexpr tactus::stub::Kind kKind = tactus::stub::Kind::kBuffer;
  t_buffer_obj(long c, const std::vector<float>& content, const std::string& name)
      : Record(kKind), channels(c), count(content.size()),
        samples((count + 1) / 2 + 1, "buffer~ " + name) {
    std::memcpy(begin(), content.data(), count * sizeof(float));
  }
  /// The last float lies before the forbidden page.
  [[nodiscard]] float* begin() const {
    return reinterpret_cast<float*>(samples.data() + samples.all().size()) - count;
  }
  long channels;
  std::size_t count;
  tactus::stub::GuardedVector samples;
};
struct t_buffer_ref : tactus::stub::Record {
  static constexpr tactus::stub::Kind kKind = tactus::stub::Kind::kBufferRef;
  t_buffer_ref() : Record(kKind) {}
  std::string name{};
};

namespace tactus::stub {
namespace {
std::mutex buffers_mutex;
std::map<std::string, t_buffer_obj*, std::less<>>& buffers() {
  static std::map<std::string, t_buffer_obj*, std::less<>> all;
  return all;
}
constexpr unsigned kBufferThreads = kMessageThreads | static_cast<unsigned>(Role::kAudio);
} // namespace

void make_buffer(const std::string& name, long channels, const std::vector<float>& samples) {
  auto* buffer = new t_buffer_obj(channels, samples, name);
  add_record(buffer, buffer);
  const std::lock_guard lock(buffers_mutex);
  buffers()[name] = buffer;
}
} // namespace tactus::stub

using namespace tactus::stub;

t_buffer_ref* buffer_ref_new(t_object* x, t_symbol* name) {
  const ApiCall api("buffer_ref_new", static_cast<unsigned>(Role::kMain));
  if (!require_object(x, "buffer_ref_new") || !check_symbol(name, "buffer_ref_new"))
    return nullptr;
  auto* reference = new t_buffer_ref;
  add_record(reference, reference);
  reference->name = name_of(name);
  return reference;
}
t_buffer_obj* buffer_ref_getobject(t_buffer_ref* reference) {
  const ApiCall api("buffer_ref_getobject", kBufferThreads);
  const auto* known = require<t_buffer_ref>(reference, "buffer_ref_getobject");
  if (!known)
    return nullptr;
  const std::lock_guard lock(buffers_mutex);
  const auto found = buffers().find(known->name);
  return found == buffers().end() ? nullptr : found->second;
}
float* buffer_locksamples(t_buffer_obj* buffer) {
  const ApiCall api("buffer_locksamples", kBufferThreads);
  const auto* known = require<t_buffer_obj>(buffer, "buffer_locksamples");
  if (!known || known->count == 0)
    return nullptr;
  if (Call* call = current_call())
    ++call->buffer_locks;
  return known->begin();
}
void buffer_unlocksamples(t_buffer_obj* buffer) {
  const ApiCall api("buffer_unlocksamples", kBufferThreads);
  require<t_buffer_obj>(buffer, "buffer_unlocksamples");
  Call* call = current_call();
  if (!call || call->buffer_locks == 0)
    violation("buffer_unlocksamples without buffer_locksamples");
  else
    --call->buffer_locks;
}
t_atom_long buffer_getchannelcount(t_buffer_obj* buffer) {
  const ApiCall api("buffer_getchannelcount", kBufferThreads);
  const auto* known = require<t_buffer_obj>(buffer, "buffer_getchannelcount");
  return known ? known->channels : 0;
}
t_atom_long buffer_getframecount(t_buffer_obj* buffer) {
  const ApiCall api("buffer_getframecount", kBufferThreads);
  const auto* known = require<t_buffer_obj>(buffer, "buffer_getframecount");
  return known ? static_cast<t_atom_long>(known->count) / known->channels : 0;
}
