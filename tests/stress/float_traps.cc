// SPDX-License-Identifier: Apache-2.0
// Finds invalid and overflowing floating-point operations in a program's own code: a library for LD_PRELOAD.
//
//   LD_PRELOAD=build/release/lib/libstress_float_traps.so build/release/bin/patina ...
//
// Every such operation stops its thread (SIGFPE). It is counted by its address, masked, carried out as a
// single step and unmasked again (SIGTRAP), so that the program goes on as it would without. At the end the
// places within the program and its plugins are printed to standard error, with the offsets that `addr2line
// -Cfie FILE OFFSET` takes; those of other libraries (Embree, OpenImageIO ...) are summed up only. x86-64
// Linux.
//
// Comparisons with NaN and conversions of what no integer holds are invalid operations, too. Optimised loops
// compute lanes whose results they drop: a build with -O1 has none of those.
#include <dlfcn.h>
#include <fenv.h>
#include <signal.h>
#include <sys/ucontext.h>

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstring>

namespace {

constexpr uint32_t kTrapped = FE_INVALID | FE_OVERFLOW;  // as in MXCSR, whose masks lie seven bits above
constexpr int kMaskShift = 7;
constexpr greg_t kTrapFlag = 0x100;
constexpr size_t kPlaces = 1 << 14;

struct Place {
  std::atomic<uintptr_t> address = 0;
  std::atomic<uint64_t> count = 0;
  std::atomic<uint32_t> kinds = 0;
};
Place places[kPlaces];
std::atomic<uint64_t> lost = 0;

void note(uintptr_t address, uint32_t kinds) {
  size_t k = (address * 0x9e3779b97f4a7c15u) >> 50;
  for (size_t tries = 0; tries < kPlaces; ++tries, k = (k + 1) % kPlaces) {
    uintptr_t there = 0;
    if (places[k].address.compare_exchange_strong(there, address) || there == address) {
      ++places[k].count, places[k].kinds |= kinds;
      return;
    }
  }
  ++lost;
}

void onException(int, siginfo_t*, void* context) {
  auto& c = static_cast<ucontext_t*>(context)->uc_mcontext;
  note(static_cast<uintptr_t>(c.gregs[REG_RIP]), c.fpregs->mxcsr & kTrapped);
  c.fpregs->mxcsr = (c.fpregs->mxcsr & ~kTrapped) | kTrapped << kMaskShift;
  c.gregs[REG_EFL] |= kTrapFlag;
}

void onStep(int, siginfo_t*, void* context) {
  auto& c = static_cast<ucontext_t*>(context)->uc_mcontext;
  c.fpregs->mxcsr &= ~(kTrapped | kTrapped << kMaskShift);
  c.gregs[REG_EFL] &= ~kTrapFlag;
}

/// Code of this repository: the program, its plugins and modules.
bool isOwn(const Dl_info& where) {
  return where.dli_fname && (std::strstr(where.dli_fname, "patina") || std::strstr(where.dli_fname, "/bin/"));
}

__attribute__((constructor)) void begin() {
  struct sigaction action {};
  action.sa_flags = SA_SIGINFO | SA_NODEFER;
  action.sa_sigaction = onException;
  sigaction(SIGFPE, &action, nullptr);
  action.sa_sigaction = onStep;
  sigaction(SIGTRAP, &action, nullptr);
  feenableexcept(FE_INVALID | FE_OVERFLOW);  // threads that are started later inherit it
}

__attribute__((destructor)) void end() {
  fedisableexcept(FE_ALL_EXCEPT);
  uint64_t elsewhere = 0;
  for (const Place& place : places) {
    const uintptr_t address = place.address;
    if (address == 0) continue;
    Dl_info where{};
    if (!dladdr(reinterpret_cast<void*>(address), &where) || !isOwn(where)) {
      elsewhere += place.count;
      continue;
    }
    std::fprintf(stderr, "float trap: %s%s %s+0x%lx, %lu times\n", place.kinds & FE_INVALID ? "invalid" : "",
                 place.kinds & FE_OVERFLOW ? "overflow" : "", where.dli_fname,
                 address - reinterpret_cast<uintptr_t>(where.dli_fbase),
                 static_cast<unsigned long>(place.count));
  }
  std::fprintf(stderr, "float trap: %lu in other libraries, %lu not kept\n",
               static_cast<unsigned long>(elsewhere), static_cast<unsigned long>(lost.load()));
}

}  // namespace
