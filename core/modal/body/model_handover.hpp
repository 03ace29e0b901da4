#pragma once

#include "core/modal/body/body_model.hpp"

#include <atomic>
#include <memory>
#include <utility>

namespace tactus::modal {

/// Hands models from the thread that builds them to the audio thread, and hands back, for deletion,
/// the models that the audio thread no longer uses. Lock-free; the audio thread allocates and frees
/// nothing.
class ModelHandover {
  struct Entry;

public:
  /// A model that the audio thread uses, counted by that thread alone.
  class Use {
  public:
    Use() = default;
    explicit Use(Entry* entry) noexcept : entry_(entry) {
      if (entry_)
        ++entry_->uses;
    }
    Use(const Use& other) noexcept : Use(other.entry_) {}
    Use(Use&& other) noexcept : entry_(std::exchange(other.entry_, nullptr)) {}
    Use& operator=(Use other) noexcept {
      std::swap(entry_, other.entry_);
      return *this;
    }
    ~Use() {
      if (entry_ && --entry_->uses == 0)
        entry_->home->retire(entry_);
    }
    [[nodiscard]] BodyModel* get() const noexcept { return entry_ ? entry_->model.get() : nullptr; }
    BodyModel& operator*() const noexcept { return *entry_->model; }
    BodyModel* operator->() const noexcept { return entry_->model.get(); }
    explicit operator bool() const noexcept { return entry_ != nullptr; }
    /// True if the model was published as the same body.
    [[nodiscard]] bool same_body() const noexcept { return entry_->same_body; }

  private:
    Entry* entry_ = nullptr;
  };

  ModelHandover() = default;
  ModelHandover(const ModelHandover&) = delete;
  ModelHandover& operator=(const ModelHandover&) = delete;
  /// Every Use must have been destroyed before.
  ~ModelHandover() {
    delete incoming_.load();
    delete_retired();
  }

  /// A model that has not been taken yet is dropped. Called by one thread at a time.
  void publish(std::unique_ptr<BodyModel> model, bool same_body) {
    delete_retired();
    auto* const entry = new Entry{std::move(model), same_body, this};
    delete incoming_.exchange(entry, std::memory_order_acq_rel);
  }
  /// The model published last, unless it has been taken. By the audio thread.
  [[nodiscard]] Use take() noexcept {
    return Use(incoming_.exchange(nullptr, std::memory_order_acq_rel));
  }

private:
  struct Entry {
    std::unique_ptr<BodyModel> model;
    bool same_body = false;
    ModelHandover* home = nullptr;
    int uses = 0;
    Entry* next = nullptr; ///< next in the list of retired entries
  };
  void delete_retired() noexcept {
    Entry* entry = retired_.exchange(nullptr, std::memory_order_acq_rel);
    while (entry)
      delete std::exchange(entry, entry->next);
  }
  void retire(Entry* entry) noexcept {
    entry->next = retired_.load(std::memory_order_relaxed);
    while (!retired_.compare_exchange_weak(entry->next, entry, std::memory_order_acq_rel)) {
    }
  }
  std::atomic<Entry*> incoming_{nullptr}, retired_{nullptr};
};

} // namespace tactus::modal
