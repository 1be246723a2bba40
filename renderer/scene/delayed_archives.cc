// SPDX-License-Identifier: Apache-2.0
// Archives that are read when a ray first meets their bound: what is kept of the request, and the reading.
#include <fmt/format.h>

#include <algorithm>

#include "renderer/base/statistics.h"
#include "renderer/scene/matrices.h"
#include "renderer/scene/scene_builder.h"
#include "renderer/scene/shape_motion.h"

namespace patina {
namespace {

STAT_COUNTER("Delayed archives/requests", requestCount);
STAT_COUNTER("Delayed archives/read", readCount);
STAT_COUNTER("Delayed archives/bytes read", byteCount);

constexpr size_t kDeepest = 64;  // delayed archives within each other, as ParserLimits::depth
constexpr float kRiInfinity = 1e37f;

}  // namespace

// ---- The request ------------------------------------------------------------------------------------------

/// Keeps a request for later. False: it is to be read now, as its geometry must be known from the beginning
/// (it is part of an object or solid, or emits), or because its bound says nothing: it has no end, or moves
/// by a motion block around the request.
bool SceneBuilder::delay(std::string_view file, const Bounds6& bound, const Location& at) {
  const bool ordered = bound[0] <= bound[1] && bound[2] <= bound[3] && bound[4] <= bound[5];
  if (!ordered) {
    warning(
        RiError::Range, at,
        fmt::format("the bound of delayed archive \"{}\" is empty (expected xmin <= xmax and the same for "
                    "y and z): it is read at once",
                    file),
        "delayed bound");
    return false;
  }
  for (const float side : bound)
    if (!(std::abs(side) < kRiInfinity)) return false;
  if (!inWorld() || inObject() || blocks_.isOpen(BlockKind::Solid) || state_.moving.outer ||
      state_.attributes.areaLight != kNone || !isAffine(state_.ctm))
    return false;

  DelayedState now{state_, archives_.chain(), {}};
  now.state.ctm = M44d();
  now.state.stored = kNone;  // numbers of this scene mean nothing in that of the archive
  for (const ScopedSystem& scoped : scopedSystems_)
    if (const auto meaning = namedTransform(scoped.name)) now.systems.emplace_back(scoped.name, *meaning);
  if (!lastDelayed_ || !(*lastDelayed_ == now))
    lastDelayed_ = std::make_shared<const DelayedState>(std::move(now));
  scene_.delayed.push_back({std::string(file),
                            Box3f({bound[0], bound[2], bound[4]}, {bound[1], bound[3], bound[5]}), state_.ctm,
                            lastDelayed_, at, state_.attributes.sampleMotion});
  ++requestCount;
  return true;
}

bool SceneBuilder::leaveOutLight(std::string_view name, const Location& at) {
  if (!outer_) return false;
  warning(RiError::IllState, at,
          fmt::format("light \"{}\" in a delayed archive is left out: lights must be known before rays are "
                      "traced (ReadArchive reads at once)",
                      name),
          "light in a delayed archive");
  return true;
}

bool SceneBuilder::emits(uint32_t object) const {
  const SceneBuilder* builder = this;
  while (object < builder->scene_.firstObject) builder = builder->outer_;
  const auto& primitives = builder->scene_.objects[object - builder->scene_.firstObject].primitives;
  return std::ranges::any_of(primitives, [&](const Primitive& p) {
    return p.attributes != kNone && builder->scene_.attributes[p.attributes].areaLight != kNone;
  });
}

void SceneBuilder::nameLateOption(std::string_view request, const Location& at) {
  constexpr std::string_view kOptions[] = {
      "Camera",        "Clipping",     "ColorSamples", "CropWindow",       "DepthOfField",  "Display",
      "DisplayFilter", "Exposure",     "Format",       "FrameAspectRatio", "Hider",         "Imager",
      "Integrator",    "Option",       "PixelFilter",  "PixelSamples",     "PixelVariance", "Quantize",
      "SampleFilter",  "ScreenWindow", "Shutter"};
  if (outer_ && std::ranges::find(kOptions, request) != std::end(kOptions))
    countNotice(fmt::format("{} in a delayed archive has no effect: options are those of WorldEnd", request),
                at);
}

// ---- Reading ----------------------------------------------------------------------------------------------

std::shared_ptr<const Scene> SceneBuilder::readDelayed(const DelayedArchive& archive,
                                                       ErrorHandler& errors) const {
  if (archive.state->chain.size() >= kDeepest) {
    errors.report(Severity::Error, RiError::LimitCheck, archive.where,
                  fmt::format("delayed archives are nested more than {} deep", kDeepest));
    return nullptr;
  }
  const ErrorHandler::OnBehalf onBehalf(
      errors, fmt::format("in delayed archive \"{}\" of {}", archive.file, toString(archive.where)));
  std::shared_ptr<SceneBuilder> builder(new SceneBuilder(*this, archive, errors));
  bool read = false;
  builder->inOwnScope(archive.where, [&] { read = builder->readArchiveFile(archive.file, archive.where); });
  settleMotion(builder->scene_);
  builder->reportNotices();
  byteCount += static_cast<int64_t>(builder->archives_.bytesRead());
  if (read) ++readCount;
  Scene& scene = builder->scene_;
  if (scene.delayed.empty()) return std::make_shared<const Scene>(std::move(scene));
  // Archives within this one are read by its own builder.
  scene.readDelayed = [keep = builder.get()](const DelayedArchive& inner, ErrorHandler& to) {
    return keep->readDelayed(inner, to);
  };
  return {builder, &scene};
}

void checkDelayed(const Scene& scene, ErrorHandler& errors) {
  for (const DelayedArchive& archive : scene.delayed) {
    if (errors.aborted()) return;
    if (const auto inner = scene.readDelayed(archive, errors)) checkDelayed(*inner, errors);
  }
}

}  // namespace patina
