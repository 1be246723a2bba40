// SPDX-License-Identifier: Apache-2.0
// Binds a shader: values into world space, `prepare`, and a check of the traits that come back.
#include "renderer/shading/shader_instance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "renderer/base/statistics.h"
#include "renderer/shading/plugin_file.h"
#include "renderer/shading/ray_service.h"
#include "renderer/shading/shader_argument.h"
#include "renderer/shading/texture_service.h"
#include "rib/input_files.h"
#include "rib/sandbox.h"

namespace patina {
namespace {

STAT_COUNTER("Shaders/instances", instances);

constexpr uint64_t kAllChannels = (PATINA_CHANNEL_DPDT << 1) - 1;
constexpr int32_t kFailed = -600;  // the code of a message, less two for each of these
constexpr std::string_view kCalls[] = {"displacement", "light",    "radiosity", "view",
                                       "atmosphere",   "evaluate", "sample",    "release"};
constexpr std::string_view kReasons[] = {"", "a parameter makes no sense", "something it needs is not there",
                                         "internal error"};
std::string reasonOf(PatinaStatus status) {
  return fmt::format(
      "status {} ({})", status,
      status > 0 && status < int(std::size(kReasons)) ? kReasons[status] : "not a known status");
}
constexpr uint32_t kAllEntries = (1u << PATINA_ENTRIES) - 1;

void store(const M44d& matrix, float out[16]) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) out[4 * i + j] = static_cast<float>(matrix[i][j]);
}

// One value of a parameter's type from shader to world space, in place.
void transformValue(uint32_t type, float* v, const M44d& toWorld, const M44d& fromWorld) {
  if (componentsOf(type) < 3) return;
  const V3d in(v[0], v[1], v[2]);
  V3d out = in;
  switch (type) {
    case PATINA_POINT:
      toWorld.multVecMatrix(in, out);
      break;
    case PATINA_VECTOR:
      toWorld.multDirMatrix(in, out);
      break;
    case PATINA_NORMAL:
      fromWorld.transposed().multDirMatrix(in, out);
      break;
    case PATINA_HPOINT: {
      const double h[4] = {v[0], v[1], v[2], v[3]};
      for (int j = 0; j < 4; ++j) {
        double sum = 0;
        for (int i = 0; i < 4; ++i) sum += h[i] * toWorld[i][j];
        v[j] = static_cast<float>(sum);
      }
      return;
    }
    case PATINA_MATRIX: {
      M44d matrix;
      for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = v[i];
      store(matrix * toWorld, v);
      return;
    }
    default:
      return;
  }
  for (int i = 0; i < 3; ++i) v[i] = static_cast<float>(out[i]);
}

}  // namespace

// The function table of PatinaHost; its `host` is the instance.
struct ShaderInstance::Services {
  static ShaderInstance& self(void* host) { return *static_cast<ShaderInstance*>(host); }

  static void report(void* host, PatinaReport severity, int32_t code, const char* message) {
    ShaderInstance& s = self(host);
    s.host_.report(s.name(), s.where_, severity, code, message ? message : "");
  }

  static int32_t transform(void* host, const char* from, const char* to, float matrix[16]) {
    const ShaderInstance& s = self(host);
    store(M44d(), matrix);
    if (!from || !to) return 0;
    const std::optional<M44d> first = s.host_.spaceToWorld(from, s.shaderToWorld_);
    const std::optional<M44d> second = s.host_.spaceToWorld(to, s.shaderToWorld_);
    if (!first || !second || second->determinant() == 0) return 0;
    store(*first * second->inverse(), matrix);
    return 1;
  }

  static PatinaTexture* openTexture(void* host, const char* name) {
    ShaderInstance& s = self(host);
    TextureService* textures = s.host_.textures();
    return textures && name && *name ? textures->open(name, s.where_) : nullptr;
  }

  static PatinaStatus texture(void*, PatinaTexture* texture, uint32_t count, PatinaPlane s, PatinaPlane t,
                              PatinaPlane width, PatinaOut3 color, float* alpha) {
    return TextureService::texture(texture, count, s, t, width, color, alpha);
  }

  static PatinaStatus environment(void*, PatinaTexture* texture, uint32_t count, PatinaPlane3 direction,
                                  PatinaPlane width, PatinaOut3 color) {
    return TextureService::environment(texture, count, direction, width, color);
  }

  static PatinaStatus textureSize(void*, PatinaTexture* texture, uint32_t* width, uint32_t* height,
                                  uint32_t* channels) {
    return TextureService::size(texture, width, height, channels);
  }

  static PatinaTexture* openData(void* host, const char* name) {
    ShaderInstance& s = self(host);
    TextureService* textures = s.host_.textures();
    return textures && name && *name ? textures->open(name, s.where_, TextureService::kData) : nullptr;
  }

  static const char* findFile(void* host, const char* name) {
    if (!name || !*name) return nullptr;
    thread_local std::string found;
    const Location& where = self(host).where_;
    const std::filesystem::path given(name);
    for (const std::filesystem::path& path :
         {where.file ? std::filesystem::path(*where.file).parent_path() / given : given, given}) {
      std::error_code ignored;
      if (!std::filesystem::is_regular_file(path, ignored)) continue;
      found = path.string();
      if (!readProblem(found).empty()) continue;
      noteInputFile(found);
      return found.c_str();
    }
    return nullptr;
  }

  static void setAtmosphere(void* host, PatinaAtmosphereFunction function) {
    self(host).atmosphere_ = function;
  }

  static uint32_t addLobe(void* host, const PatinaCustomLobe* lobe) {
    ShaderInstance& s = self(host);
    std::string fault = findLobeFault(lobe);
    if (fault.empty() && s.prepared_) fault = "was registered outside of prepare";
    if (fault.empty() && s.customLobes_.size() == PATINA_MAX_LOBES)
      fault = fmt::format("is one too many: there may be {}", PATINA_MAX_LOBES);
    if (!fault.empty()) {
      s.refusal_ = fmt::format("its lobe \"{}\" {}", lobe && lobe->name ? lobe->name : "", fault);
      return PATINA_LOBE_NONE;
    }
    s.customLobes_.emplace_back(*lobe, s);
    s.lobeDataCount_ = std::max(s.lobeDataCount_, lobe->data_count);
    return PATINA_LOBE_CUSTOM + static_cast<uint32_t>(s.customLobes_.size()) - 1;
  }

  static int32_t declareRays(void* host, PatinaEntry entry, uint32_t most) {
    ShaderInstance& s = self(host);
    const char* const fault = s.prepared_ ? "outside of prepare"
                              : entry != PATINA_ENTRY_RADIOSITY && entry != PATINA_ENTRY_VIEW
                                  ? "for an entry point that may trace none"
                              : most > PATINA_MAX_RAYS ? "beyond PATINA_MAX_RAYS"
                                                       : nullptr;
    if (!fault) return s.rays_[entry] = most, 1;
    s.refusal_ = fmt::format("it declares {} rays per point {}", most, fault);
    return 0;
  }

  static PatinaStatus traceRays(void* host, const PatinaRayIn* in, PatinaRayOut* out) {
    return RayCall::trace(self(host), in, out);
  }

  static int32_t getAttribute(void* host, const char* name, uint32_t type, uint32_t arrayLength,
                              PatinaValue* value) {
    ShaderInstance& s = self(host);
    if (!name || !value || s.prepared_) return 0;
    s.readsUserAttributes_ = true;
    const ShaderArgument* const found = s.user_.find(name);
    if (!found || typeOf(found->type) != type || static_cast<uint32_t>(found->arrayLength) != arrayLength)
      return 0;
    *value = {};
    if (type == PATINA_STRING) {
      auto& pointers = s.attributePointers_.emplace_back();
      for (const std::string& text : found->strings) pointers.push_back(text.c_str());
      value->strings = pointers.data();
    }
    value->floats = found->floats.empty() ? nullptr : found->floats.data();
    value->ints = found->ints.empty() ? nullptr : found->ints.data();
    value->plane = 1;
    value->count = componentsOf(type) * std::max(arrayLength, 1u);
    value->is_set = 1;
    return 1;
  }

  static int32_t bindAttribute(void* host, const char* name, const char* parameter) {
    ShaderInstance& s = self(host);
    if (!name || !*name || !parameter || s.prepared_) return 0;
    for (VaryingParameter& varying : s.varying_)
      if (varying.name == parameter) {
        varying.attribute = name;
        s.bindsUserAttributes_ = true;
        return 1;
      }
    return 0;
  }

  static const void* extension(void*, const char* id) {
    static constexpr PatinaDataTextures kDataTextures = {sizeof(PatinaDataTextures), 0, openData};
    static constexpr PatinaAtmospheres kAtmospheres = {sizeof(PatinaAtmospheres), 0, setAtmosphere};
    static constexpr PatinaLobeRegistry kLobes = {sizeof(PatinaLobeRegistry), 0, addLobe};
    static constexpr PatinaFiles kFiles = {sizeof(PatinaFiles), 0, findFile};
    static constexpr PatinaRays kRays = {sizeof(PatinaRays), 0, declareRays, traceRays};
    static constexpr PatinaAttributes kAttributes = {sizeof(PatinaAttributes), 0, getAttribute,
                                                     bindAttribute};
    if (!id) return nullptr;
    if (std::strcmp(id, PATINA_EXTENSION_FILES) == 0) return &kFiles;
    if (std::strcmp(id, PATINA_EXTENSION_ATMOSPHERE) == 0) return &kAtmospheres;
    if (std::strcmp(id, PATINA_EXTENSION_DATA_TEXTURES) == 0) return &kDataTextures;
    if (std::strcmp(id, PATINA_EXTENSION_CUSTOM_LOBES) == 0) return &kLobes;
    if (std::strcmp(id, PATINA_EXTENSION_RAYS) == 0) return &kRays;
    if (std::strcmp(id, PATINA_EXTENSION_ATTRIBUTES) == 0) return &kAttributes;
    return nullptr;
  }
};

ShaderInstance::ShaderInstance(const PatinaShader& shader, const ShaderBinding& binding, ShaderHost& host)
    : shader_(shader),
      where_(binding.where),
      shaderToWorld_(binding.shaderToWorld),
      host_(host),
      user_(binding.user) {
  worldToShader_ = shaderToWorld_.determinant() != 0 ? shaderToWorld_.inverse() : M44d();
  table_ = {sizeof(PatinaHost), PATINA_ABI_MINOR,      this,
            Services::report,   Services::transform,   Services::openTexture,
            Services::texture,  Services::environment, Services::textureSize,
            Services::extension};
}

ShaderInstance::~ShaderInstance() {
  if (!prepared_ || !shader_.release) return;
  run("release", [&] {
    shader_.release(data_);
    return PATINA_OK;
  });
}

void ShaderInstance::reportFailure(const char* entry, PatinaStatus status, const char* thrown) const {
  const CallPlace* const place = CallPlace::current();
  const std::string at = place ? ". The first is at " + place->text() : "";
  const auto call = std::find(std::begin(kCalls), std::end(kCalls), entry) - std::begin(kCalls);
  const int32_t code = kFailed - 2 * static_cast<int32_t>(call) - (thrown ? 1 : 0);
  host_.report(name(), where_, PATINA_REPORT_ERROR, code,
               thrown
                   ? fmt::format("{} threw an exception: {}; what it was called for counts as not shaded{}",
                                 entry, thrown, at)
                   : fmt::format("{} failed with {}; what it was called for counts as not shaded{}", entry,
                                 reasonOf(status), at));
}

void ShaderInstance::setDefaults() {
  const uint32_t count = shader_.parameter_count;
  values_.resize(count);
  floats_.resize(count);
  ints_.resize(count);
  strings_.resize(count);
  pointers_.resize(count);
  for (uint32_t i = 0; i < count; ++i) {
    const PatinaParameter& p = parameterOf(shader_, i);
    const uint32_t numbers = valueCountOf(p);
    if (p.type == PATINA_STRING)
      strings_[i].assign(p.default_strings, p.default_strings + numbers);
    else if (p.type == PATINA_INT)
      ints_[i].assign(p.default_ints, p.default_ints + numbers);
    else
      floats_[i].assign(p.default_floats, p.default_floats + numbers);
    if (p.storage == PATINA_VARYING) varying_.push_back({i, p.name, p.type, numbers, {}});
  }
}

// From shader space to the world, and from vectors to what a plugin sees.
void ShaderInstance::finishValues() {
  for (uint32_t i = 0; i < shader_.parameter_count; ++i) {
    const PatinaParameter& p = parameterOf(shader_, i);
    const uint32_t numbers = valueCountOf(p);
    for (uint32_t k = 0; k < floats_[i].size(); k += componentsOf(p.type))
      transformValue(p.type, &floats_[i][k], shaderToWorld_, worldToShader_);
    for (const std::string& text : strings_[i]) pointers_[i].push_back(text.c_str());
    PatinaValue& value = values_[i];
    value.floats = floats_[i].empty() ? nullptr : floats_[i].data();
    value.ints = ints_[i].empty() ? nullptr : ints_[i].data();
    value.strings = pointers_[i].empty() ? nullptr : pointers_[i].data();
    value.stride = 0;
    value.plane = 1;
    value.count = numbers;
  }
}

bool ShaderInstance::prepare(ErrorHandler& errors) {
  PatinaPrepare in{};
  in.struct_size = sizeof in;
  in.value_stride = sizeof(PatinaValue);
  in.host = &table_;
  in.values = values_.data();
  store(worldToShader_, in.world_to_shader);
  store(shaderToWorld_, in.shader_to_world);
  traits_ = {};
  traits_.struct_size = sizeof traits_;

  PatinaStatus status = PATINA_ERROR_INTERNAL;
  std::string fault;
  try {
    std::optional<WatchedCall> watched;
    if (watchesShaders()) watched.emplace(*this, "prepare");
    status = shader_.prepare(&in, &data_, &traits_);
  } catch (const std::exception& thrown) {
    fault = fmt::format("prepare threw an exception: {}", thrown.what());
  } catch (...) {
    fault = "prepare threw an exception";
  }
  prepared_ = status == PATINA_OK || data_ != nullptr;
  if (!fault.empty())
    ;  // it threw
  else if (status != PATINA_OK)
    fault = "prepare failed with " + reasonOf(status);
  else if (!refusal_.empty())
    fault = refusal_;
  else
    fault = findTraitsFault(traits_);
  if (fault.empty()) return true;
  errors.report(Severity::Error, RiError::NoShader, where_,
                fmt::format("shader \"{}\": {}", shader_.name, fault));
  return false;
}

std::string findTraitsFault(const PatinaTraits& traits) {
  static constexpr std::string_view kEntryNames[] = {"displacement", "light", "radiosity", "view"};
  if (traits.active & ~kAllEntries)
    return fmt::format("its traits name entry points that are not: {:#x}", traits.active);
  for (uint32_t entry = 0; entry < PATINA_ENTRIES; ++entry) {
    const uint64_t known = entry == PATINA_ENTRY_VIEW ? kAllChannels : kAllChannels & ~PATINA_CHANNEL_I;
    const uint64_t wrong = traits.reads[entry] & ~known;
    if (wrong & PATINA_CHANNEL_I & kAllChannels)
      return fmt::format("its traits say that {} reads I, which only view is given", kEntryNames[entry]);
    if (wrong)
      return fmt::format("its traits say that {} reads channels that are not: {:#x}", kEntryNames[entry],
                         wrong);
  }
  if (traits.light_kind > PATINA_LIGHT_AREA)
    return fmt::format("its traits have the light kind {}", traits.light_kind);
  if ((traits.active >> PATINA_ENTRY_LIGHT & 1u) && traits.light_kind == PATINA_LIGHT_NONE)
    return "its traits say that light is active, but not what kind of light it is";
  if (!std::isfinite(traits.displacement_bound) || traits.displacement_bound < 0)
    return fmt::format("its traits have the displacement bound {}", traits.displacement_bound);
  if (!std::isfinite(traits.light_power) || traits.light_power < 0)
    return fmt::format("its traits have the light power {}", traits.light_power);
  return {};
}

std::unique_ptr<ShaderInstance> ShaderInstance::create(const PatinaShader& shader,
                                                       const ShaderBinding& binding, ShaderHost& host,
                                                       ErrorHandler& errors) {
  std::unique_ptr<ShaderInstance> instance(new ShaderInstance(shader, binding, host));
  if (!(std::abs(binding.shaderToWorld.determinant()) > 0))
    errors.report(Severity::Warning, RiError::Math, binding.where,
                  fmt::format("the transformation of shader \"{}\" cannot be inverted", shader.name));
  instance->setDefaults();
  for (const ShaderArgument& argument : binding.arguments) {
    const int index = findParameter(shader, argument, errors);
    if (index < 0) continue;
    const auto i = static_cast<size_t>(index);
    const ArgumentSlot slot{instance->floats_[i], instance->ints_[i], instance->strings_[i]};
    if (bindArgument(shader, parameterOf(shader, static_cast<uint32_t>(i)), argument, slot, errors))
      instance->values_[i].is_set = 1;
  }
  instance->finishValues();
  if (!instance->prepare(errors)) return nullptr;
  ++instances;
  return instance;
}

}  // namespace patina
