// SPDX-License-Identifier: Apache-2.0
// What is made of surfaces when rays meet them, and dropped again when it takes too much memory.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "renderer/base/math.h"
#include "renderer/base/stable_vector.h"

namespace patina {

struct SurfaceRates;

/// Facets of the surfaces of a unit, and what a traversal kernel needs of them.
struct Tessellation {
  /// The structure that rays are traced against; made and known by renderer/accel.
  struct Tracer {
    virtual ~Tracer() = default;
  };

  struct Member {
    const SurfaceRates* rates = nullptr;  ///< null: traced as its flat faces, no vertices here
    size_t firstTile = 0;                 ///< index of `first` of its first tile
    size_t firstNormal = 0;               ///< displaced: index of `normals` of its first vertex
  };
  std::vector<Member> members;
  std::vector<uint32_t> first;    ///< by tile of all members: its first vertex
  std::vector<V3f> vertices;      ///< mesh space, rows along u; room for one more behind the last
  std::vector<uint32_t> normals;  ///< of displaced members, by vertex, mesh space; see packNormal()
  bool isLeftOut = false;         ///< nothing of it is traced
  size_t stride = 0;  ///< of a unit that moves: vertices of one time step; those of the next stand behind
  std::unique_ptr<Tracer> tracer;  ///< may view the vertices; the last member, so that it goes first

  size_t bytes() const {  ///< without the tracer's
    return sizeof(*this) + vertices.capacity() * sizeof(V3f) + members.capacity() * sizeof(Member) +
           (first.capacity() + normals.capacity()) * sizeof(uint32_t);
  }
};

/// Keeps tessellations of units within a budget of bytes. A unit is tessellated when it is first asked for,
/// and again whenever it is asked for after it had to go; those that were met least recently go first. What a
/// tessellation holds is a function of its unit alone.
///
/// The budget holds at every moment: room is made before a unit is, for as many bytes as the maker guesses
/// that making it takes, and a unit waits while others are being made that leave it none. Only a unit that is
/// larger than the budget by itself exceeds it.
///
/// Readers take no lock. What they got stays until their Reader ends (epoch-based reclamation, K. Fraser
/// 2004, section 5.2.3): whoever drops a tessellation unlinks it, and frees it when every Reader that began
/// before has ended or is itself waiting for a tessellation.
class TessellationCache {
 public:
  struct Maker {
    /// Makes the facets of a unit. [any thread; different units at the same time]
    std::function<std::unique_ptr<Tessellation>(uint32_t unit)> make;
    /// Gives them a tracer, or leaves the unit out. [any thread]
    std::function<void(uint32_t unit, std::unique_ptr<Tessellation>&)> trace;
    /// Bytes of all tracers, those that are being made included. [any thread]
    std::function<size_t()> measure;
    /// About how many bytes are in use while a unit is being made, tracer included: rather too many than too
    /// few. [one thread at a time for a unit]
    std::function<size_t(uint32_t unit)> guess;
  };

  explicit TessellationCache(size_t budget);
  ~TessellationCache();
  TessellationCache(const TessellationCache&) = delete;
  TessellationCache& operator=(const TessellationCache&) = delete;

  /// To be called before the first Reader. [main]
  void setMaker(Maker maker);
  /// To be called before the first growTo() when there will be more. [main]
  void makeRoom() { units_.makeRoom(); }
  /// Makes it know units up to a number. [one thread at a time; others may read meanwhile]
  void growTo(size_t units) const { units_.growTo(units); }
  /// Keeps what is there of these units for good: it counts in the budget, and is never dropped. Their
  /// tracers are no longer needed and go. Nobody may read meanwhile. [main]
  void pin(std::span<const uint32_t> units) const;
  /// The tessellation of a unit if it is there, else null. Nobody may drop any meanwhile. [main]
  const Tessellation* resident(uint32_t unit) const { return units_[unit].resident.load(); }
  /// Drops everything, and the maker with it: nobody may read any more. [main]
  void clear();

  /// A thread that looks at tessellations. One at a time per thread, and short: a ray, or a facet.
  class Reader {
   public:
    explicit Reader(const TessellationCache& cache) : cache_(cache), epoch_(ownEpoch()) { begin(); }
    ~Reader() { epoch_.store(0, std::memory_order_release); }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;
    /// The tessellation of a unit if it is there, else null.
    const Tessellation* find(uint32_t unit) {
      Unit& wanted = cache_.units_[unit];
      const Tessellation* const known = wanted.resident.load();
      if (!known) return nullptr;
      const uint32_t clock = cache_.clock_.load(std::memory_order_relaxed);
      if (wanted.lastMet.load(std::memory_order_relaxed) != clock)
        wanted.lastMet.store(clock, std::memory_order_relaxed);
      return known;
    }
    /// Does what may take long, or waits: what this Reader got before is no longer valid.
    template <typename Work>
    decltype(auto) whileHoldingNothing(const Work& work) {
      epoch_.store(0, std::memory_order_release);
      struct Again {
        Reader& reader;
        ~Again() { reader.begin(); }
      } const again{*this};
      return work();
    }
    /// The tessellation of a unit, made now if need be: then what this Reader got before is no longer valid.
    const Tessellation& get(uint32_t unit) {
      for (;;) {
        if (const Tessellation* known = find(unit)) return *known;
        // While it waits a Reader holds nothing, so that nobody waits for it.
        epoch_.store(0, std::memory_order_release);
        cache_.load(unit);
        begin();
      }
    }

   private:
    /// Either what is read next is ordered behind the epoch here, or whoever drops a tessellation fences all
    /// threads (Epochs::waitForReaders).
    void begin() {
      const uint64_t now = currentEpoch.load(std::memory_order_relaxed);
      if (ordersReaders) {
        epoch_.exchange(now);
      } else {
        epoch_.store(now, std::memory_order_relaxed);
        std::atomic_signal_fence(std::memory_order_seq_cst);
      }
    }

    const TessellationCache& cache_;
    std::atomic<uint64_t>& epoch_;  ///< of this thread: when its Reader began; 0 = none
  };

  size_t units() const { return units_.size(); }
  size_t budget() const { return budget_; }
  size_t peak() const { return peak_; }  ///< most bytes in use
  /// Something had to go: who asks for many units had better ask in their order. Never unset. [any thread]
  bool isTight() const { return tight_.load(std::memory_order_relaxed); }
  /// Looks at how much is in use now, for peak(). [any thread]
  void notePeak() const;
  size_t madeAgain() const { return madeAgain_; }  ///< how often units were made that had been dropped
  size_t bytesOfAll() const;                       ///< that all units that were ever made would take [main]

 private:
  friend class Epochs;
  static constinit inline std::atomic<uint64_t> currentEpoch = 1;
  static const bool ordersReaders;  ///< the system cannot fence all threads at once
  static constinit inline thread_local std::atomic<uint64_t>* threadEpoch = nullptr;
  static std::atomic<uint64_t>& ownEpoch() { return threadEpoch ? *threadEpoch : takeEpoch(); }
  static std::atomic<uint64_t>& takeEpoch();

  struct Unit {
    std::atomic<Tessellation*> resident = nullptr;
    std::atomic<uint32_t> lastMet = 0;  ///< value of clock_
    std::atomic<bool> made = false;     ///< at least once
    size_t bytes = 0;                   ///< that making it took last; guarded by `mutex`
    std::mutex mutex;                   ///< held while it is being made
  };
  void load(uint32_t unit) const;
  void reserve(size_t bytes) const;
  bool dropSome() const;
  size_t used() const { return bytes_ + maker_.measure(); }

  mutable StableVector<Unit> units_;
  size_t budget_;
  Maker maker_;
  mutable std::mutex reserveMutex_;
  mutable std::condition_variable makingEnded_;
  mutable size_t reserved_ = 0;   ///< for units that are being made; guarded by reserveMutex_
  mutable uint32_t makings_ = 0;  ///< at the moment; guarded by reserveMutex_
  mutable std::atomic<bool> tight_ = false;
  mutable std::mutex evictMutex_;
  mutable std::vector<uint32_t> resident_;   ///< units; guarded by evictMutex_
  mutable std::atomic<uint32_t> clock_ = 1;  ///< counts makings
  mutable std::atomic<size_t> bytes_ = 0, peak_ = 0, madeAgain_ = 0;
};

}  // namespace patina
