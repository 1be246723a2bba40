// SPDX-License-Identifier: Apache-2.0
// Opens plugins: the shared object, its exported symbol, and the descriptors behind it.
#include "renderer/shading/plugin_file.h"

#include <dlfcn.h>
#include <elf.h>
#include <fmt/format.h>
#include <link.h>

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <set>

namespace patina {
namespace {

// Sizes of the structs of version 1.0: what any plugin of this major version has at least.
constexpr uint32_t kShaderSize = offsetof(PatinaShader, view) + sizeof(PatinaShader::view);
constexpr uint32_t kParameterSize = offsetof(PatinaParameter, maximum) + sizeof(PatinaParameter::maximum);
constexpr uint32_t kMaxParameters = 4096;
constexpr size_t kMaxShaders = 4096;
constexpr uint32_t kMaxArrayLength = 1u << 20;

// A plugin's constructors (those of -ffast-math among them) must not change how this thread rounds.
class KeepFloatingPoint {
 public:
  KeepFloatingPoint() { std::fegetenv(&environment_); }
  ~KeepFloatingPoint() { std::fesetenv(&environment_); }
  KeepFloatingPoint(const KeepFloatingPoint&) = delete;
  KeepFloatingPoint& operator=(const KeepFloatingPoint&) = delete;

 private:
  std::fenv_t environment_;
};

// Whether the file is a whole shared object: the loader maps what the headers promise, and would die of a
// file that was cut off on its way here.
std::string findFileFault(const std::string& path) {
  using Header = ElfW(Ehdr);
  using Segment = ElfW(Phdr);
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return "it cannot be read";
  const auto size = static_cast<uint64_t>(file.tellg());
  file.seekg(0);
  Header header{};
  file.read(reinterpret_cast<char*>(&header), sizeof header);
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0)
    return "it is not a plugin: not a shared object (no ELF header)";
  if (!file) return "it is not a plugin: the file is cut off";
  constexpr unsigned char kClass = sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32;
  if (header.e_ident[EI_CLASS] != kClass || header.e_phentsize != sizeof(Segment))
    return "it is not a plugin: a shared object for another kind of machine";
  if (header.e_type != ET_DYN) return "it is not a plugin: an ELF file, but not a shared object";
  file.seekg(static_cast<std::streamoff>(header.e_phoff));
  for (unsigned i = 0; i < header.e_phnum; ++i) {
    Segment segment{};
    file.read(reinterpret_cast<char*>(&segment), sizeof segment);
    if (!file || (segment.p_type == PT_LOAD &&
                  (segment.p_offset > size || segment.p_filesz > size - segment.p_offset)))
      return "it is not a plugin: the file is cut off";
  }
  return {};
}

// How many pointers the symbol holds at most: what its size in the file says.
size_t tableLength(const void* symbol) {
  Dl_info where{};
  void* entry = nullptr;
  if (!dladdr1(symbol, &where, &entry, RTLD_DL_SYMENT) || !entry) return kMaxShaders;
  return static_cast<const ElfW(Sym)*>(entry)->st_size / sizeof(void*);
}

std::string describeMissingSymbol(void* library) {
  for (unsigned major = 0; major < 10; ++major) {
    if (major == PATINA_ABI_MAJOR) continue;
    if (dlsym(library, fmt::format("patina_shaders_v{}", major).c_str()))
      return fmt::format(
          "it was built for version {} of the shader ABI, and this is version {}: compile it again", major,
          PATINA_ABI_MAJOR);
  }
  return fmt::format("it is not a plugin: it exports no symbol patina_shaders_v{}", PATINA_ABI_MAJOR);
}

std::string findParameterFault(const PatinaShader& shader, uint32_t index) {
  const PatinaParameter& p = parameterOf(shader, index);
  if (p.struct_size < kParameterSize)
    return fmt::format("parameter {} has struct_size {}, less than {}", index, p.struct_size, kParameterSize);
  if (!p.name || !*p.name) return fmt::format("parameter {} has no name", index);
  if (!p.doc || !p.unit) return fmt::format("parameter \"{}\" has a NULL doc or unit", p.name);
  if (!componentsOf(p.type)) return fmt::format("parameter \"{}\" has the unknown type {}", p.name, p.type);
  if (p.storage != PATINA_UNIFORM && p.storage != PATINA_VARYING)
    return fmt::format("parameter \"{}\" has the unknown storage class {}", p.name, p.storage);
  if (p.storage == PATINA_VARYING && (p.type == PATINA_STRING || p.type == PATINA_INT))
    return fmt::format("parameter \"{}\" is a varying {}; strings and ints are uniform", p.name,
                       typeName(p.type));
  if (p.array_length > kMaxArrayLength)
    return fmt::format("parameter \"{}\" is an array of {}", p.name, p.array_length);
  const bool floats = p.type != PATINA_STRING && p.type != PATINA_INT;
  if (!p.default_floats != !floats || !p.default_ints != (p.type != PATINA_INT) ||
      !p.default_strings != (p.type != PATINA_STRING))
    return fmt::format("parameter \"{}\" lacks a default of its type {}", p.name, typeName(p.type));
  if (std::isnan(p.minimum) || std::isnan(p.maximum))
    return fmt::format("parameter \"{}\" has a range that is not a number", p.name);
  const uint32_t elements = p.array_length ? p.array_length : 1;
  for (uint32_t i = 0; floats && i < elements * componentsOf(p.type); ++i)
    if (!std::isfinite(p.default_floats[i]))
      return fmt::format("parameter \"{}\" has a default that is not finite", p.name);
  for (uint32_t i = 0; p.type == PATINA_STRING && i < elements; ++i)
    if (!p.default_strings[i]) return fmt::format("parameter \"{}\" has a NULL default", p.name);
  return {};
}

}  // namespace

uint32_t componentsOf(uint32_t type) {
  switch (type) {
    case PATINA_FLOAT:
    case PATINA_INT:
    case PATINA_STRING:
      return 1;
    case PATINA_COLOR:
    case PATINA_POINT:
    case PATINA_VECTOR:
    case PATINA_NORMAL:
      return 3;
    case PATINA_HPOINT:
      return 4;
    case PATINA_MATRIX:
      return 16;
    default:
      return 0;
  }
}

std::string_view typeName(uint32_t type) {
  static constexpr std::string_view kNames[] = {"?",     "float",  "int",    "string", "color",
                                                "point", "vector", "normal", "matrix", "hpoint"};
  return kNames[type < std::size(kNames) ? type : 0];
}

const PatinaParameter& parameterOf(const PatinaShader& shader, uint32_t index) {
  const auto* first = reinterpret_cast<const std::byte*>(shader.parameters);
  return *reinterpret_cast<const PatinaParameter*>(first + size_t(index) * shader.parameter_stride);
}

std::string findDescriptorFault(const PatinaShader& shader) {
  if (shader.struct_size < kShaderSize)
    return fmt::format("its descriptor has struct_size {}, less than {}", shader.struct_size, kShaderSize);
  if (!shader.name || !*shader.name) return "one of its shaders has no name";
  if (!shader.doc) return fmt::format("shader \"{}\" has a NULL doc", shader.name);
  const std::pair<bool, std::string_view> entries[] = {{shader.prepare != nullptr, "prepare"},
                                                       {shader.displacement != nullptr, "displacement"},
                                                       {shader.light != nullptr, "light"},
                                                       {shader.radiosity != nullptr, "radiosity"},
                                                       {shader.view != nullptr, "view"}};
  for (const auto& [present, entry] : entries)
    if (!present)
      return fmt::format(
          "shader \"{}\" lacks the entry point \"{}\" (it is NULL; prepare and all of displacement, light, "
          "radiosity "
          "and view are mandatory)",
          shader.name, entry);
  if (shader.parameter_count == 0) return {};
  if (shader.parameter_count > kMaxParameters || !shader.parameters)
    return fmt::format("shader \"{}\" has a bad parameter table: {} parameters{}", shader.name,
                       shader.parameter_count, shader.parameters ? "" : " at NULL");
  if (shader.parameter_stride < kParameterSize || shader.parameter_stride % alignof(PatinaParameter) != 0)
    return fmt::format("shader \"{}\" has a bad parameter table: a stride of {} bytes", shader.name,
                       shader.parameter_stride);
  std::set<std::string_view> names;
  for (uint32_t i = 0; i < shader.parameter_count; ++i) {
    std::string fault = findParameterFault(shader, i);
    if (fault.empty() && !names.insert(parameterOf(shader, i).name).second)
      fault = fmt::format("parameter \"{}\" is there twice", parameterOf(shader, i).name);
    if (!fault.empty()) return fmt::format("shader \"{}\" has a bad parameter table: {}", shader.name, fault);
  }
  return {};
}

std::unique_ptr<PluginFile> PluginFile::open(const std::string& path, std::string& reason) {
  reason = findFileFault(path);
  if (!reason.empty()) return nullptr;

  const KeepFloatingPoint guard;
  // A name without a slash would be looked for among the system's libraries.
  void* library = dlopen((path.find('/') == path.npos ? "./" + path : path).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) {
    const char* text = dlerror();
    reason = fmt::format("it cannot be loaded, the loader says: {}", text ? text : "nothing");
    return nullptr;
  }
  std::unique_ptr<PluginFile> plugin(new PluginFile(path, library));
  const void* symbol = dlsym(library, "patina_shaders_v1");
  static_assert(PATINA_ABI_MAJOR == 1, "the symbol's name carries the major version");
  if (!symbol) {
    reason = describeMissingSymbol(library);
    return nullptr;
  }
  const size_t length = std::min(tableLength(symbol), kMaxShaders);
  const auto* table = static_cast<const PatinaShader* const*>(symbol);
  for (size_t i = 0; i == length || table[i]; ++i) {
    reason =
        i == length ? "its table patina_shaders_v1 does not end with NULL" : findDescriptorFault(*table[i]);
    if (!reason.empty()) return nullptr;
    plugin->shaders_.push_back(table[i]);
  }
  if (!plugin->shaders_.empty()) return plugin;
  reason = "its table patina_shaders_v1 is empty";
  return nullptr;
}

PluginFile::~PluginFile() {
  const KeepFloatingPoint guard;
  dlclose(library_);
}

const PatinaShader* PluginFile::find(std::string_view name) const {
  for (const PatinaShader* shader : shaders_)
    if (name == shader->name) return shader;
  return nullptr;
}

}  // namespace patina
