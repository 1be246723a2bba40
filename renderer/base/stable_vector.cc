// SPDX-License-Identifier: Apache-2.0
// Address space by mmap, memory in it by mprotect: pages that are not touched cost nothing.
#include "renderer/base/stable_vector.h"

#include <sys/mman.h>
#include <sys/resource.h>

#include <algorithm>

namespace patina {
namespace {

constexpr size_t kStep = size_t{1} << 16;  // a multiple of all page sizes

size_t wholeSteps(size_t bytes) { return (bytes + kStep - 1) / kStep * kStep; }

}  // namespace

AddressRange::AddressRange(size_t bytes) : size_(wholeSteps(std::max(bytes, kStep))) {
  data_ = mmap(nullptr, size_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (data_ == MAP_FAILED) throw std::bad_alloc();
}

size_t AddressRange::most(size_t elementBytes) {
  constexpr size_t kMost = size_t{1} << 26, kShare = 64;
  size_t bytes = kMost * elementBytes;
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    bytes = std::min<size_t>(bytes, limit.rlim_cur / kShare);
  return bytes;
}

AddressRange::~AddressRange() { munmap(data_, size_); }

void AddressRange::useMore(size_t bytes) {
  if (bytes > size_) throw std::bad_alloc();
  // Ahead of what is asked for, so that many small steps are few calls.
  const size_t wanted = std::min(wholeSteps(std::max(bytes, used_ + used_ / 2)), size_);
  if (mprotect(static_cast<char*>(data_) + used_, wanted - used_, PROT_READ | PROT_WRITE) != 0)
    throw std::bad_alloc();
  used_ = wanted;
}

}  // namespace patina
