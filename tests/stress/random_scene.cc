// SPDX-License-Identifier: Apache-2.0
// Camera, lights, attributes and shaders around random shapes.
#include "tests/stress/random_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "tests/stress/random_shapes.h"

namespace patina::stress {
namespace {

constexpr std::array<std::string_view, 7> kLights = {
    "ambientlight", "pointlight", "distantlight", "spotlight", "envlight", "sunsky", "arealight"};
constexpr std::array<std::string_view, 5> kDisplacements = {"bumpy", "dented", "displace", "noisebump",
                                                            "waves"};
constexpr std::array<std::string_view, 2> kAtmospheres = {"fog", "depthcue"};

template <size_t N>
bool isOneOf(const std::array<std::string_view, N>& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

class Maker {
 public:
  Maker(uint64_t number, const std::vector<LibraryShader>& library, RandomLight light)
      : dice_(number), library_(library), isSane_(light == RandomLight::Sane) {
    for (const LibraryShader& s : library)
      if (!isOneOf(kLights, s.name) && !isOneOf(kDisplacements, s.name) && !isOneOf(kAtmospheres, s.name))
        surfaces_.push_back(&s);
    wild_ = dice_.chance(0.35) && !isSane_;
    notes_.allowStrangeColors = !isSane_;
  }

  RandomScene make() {
    camera();
    add("WorldBegin\n");
    lights();
    for (int k = dice_.below(5) + 2; k > 0; --k) object();
    add("WorldEnd\n");
    if (notes_.strangeColors) scene_.comparable = false;
    scene_.ingredients.insert(scene_.ingredients.end(), notes_.ingredients.begin(), notes_.ingredients.end());
    return std::move(scene_);
  }

 private:
  template <class... Parts>
  void add(fmt::format_string<Parts...> format, Parts&&... parts) {
    scene_.rib += fmt::format(format, std::forward<Parts>(parts)...);
  }
  void note(const char* what) { notes_.ingredients.insert(what); }
  /// Light that no closed form allows: the modes need not agree on it.
  void noteWild(const char* what) { note(what), scene_.comparable = false; }
  std::string triple(double low, double high) {
    return numbers(std::array{dice_.range(low, high), dice_.range(low, high), dice_.range(low, high)});
  }

  void camera() {
    std::string format = "16 16 1";
    if (dice_.chance(0.06)) format = "1 1 1", note("picture of one pixel");
    if (dice_.chance(0.04))
      format = dice_.pick({"1 3000 1", "3000 1 1"}), note("picture of one row or column");
    if (dice_.chance(0.05))
      format = dice_.pick({"16 16 1e-6", "16 16 1e6", "16 16 -1"}), note("odd pixel aspect");
    add("Format {}\nPixelSamples {} {}\n", format, dice_.pick({1, 2, 3}), dice_.pick({1, 2}));
    std::string filter = dice_.pick({"box", "gaussian", "triangle", "catmull-rom", "sinc"});
    // Where weights may be negative their sum is next to nothing by chance: means of few samples have no
    // variance.
    if (isSane_ && (filter == "catmull-rom" || filter == "sinc")) filter = "gaussian";
    add("PixelFilter \"{}\" {} {}\n", filter, dice_.pick({1.0, 2.0, 4.0}), dice_.pick({1.0, 2.0}));
    if (dice_.chance(0.05) && !isSane_) add("CropWindow .4 .41 .2 .9\n"), note("narrow crop window");
    double fov = 45;
    if (dice_.chance(0.2)) fov = dice_.pick({0.001, 179.9, 1.0, 170.0}), note("odd field of view");
    if (dice_.chance(0.1))
      add("Projection \"orthographic\"\n");
    else
      add("Projection \"perspective\" \"fov\" [{}]\n", number(fov));
    if (dice_.chance(0.1))
      add("DepthOfField {} {} {}\n", dice_.pick({2.8, 0.001, 1e30}), dice_.pick({0.05, 10.0}),
          dice_.pick({5.0, 1e-3, 1e20})),
          note("odd depth of field");
    if (dice_.chance(0.1))
      add("Clipping {} {}\n", dice_.pick({1e-30, 0.1, 4.0}), dice_.pick({4.5, 1e30})), note("odd clipping");
    moves_ = dice_.chance(0.25);
    if (moves_) add("Shutter 0 1\n"), note("motion blur");
    add("Attribute \"trace\" \"int maxdiffusedepth\" [{}] \"int maxspeculardepth\" [{}]\n",
        dice_.pick({0, 1, 2, 4}), dice_.pick({0, 2, 4}));
    double distance = 4;
    if (dice_.chance(0.15)) distance = 0, note("camera inside of objects");
    if (dice_.chance(0.1)) distance = dice_.pick({1.0, 0.8, 0.5}), note("camera on a surface");
    if (dice_.chance(0.04)) distance = dice_.pick({1e6, 1e15}), note("camera far away");
    add("Translate 0 0 {}\nRotate {} 0 1 0\nRotate {} 1 0 0\n", number(distance), number(dice_.range(0, 360)),
        number(dice_.range(-60, 60)));
  }

  /// A shader's name and some of its parameters; a light's handle stands between them.
  std::string shader(const LibraryShader& s, int handle = 0) {
    std::string text = fmt::format("\"{}\"", s.name);
    if (handle > 0) text += fmt::format(" {}", handle);
    for (const ShaderParameter& p : s.parameters) {
      if (!dice_.chance(0.4)) continue;
      const bool hasRange = std::isfinite(p.minimum) && std::isfinite(p.maximum) && p.minimum < p.maximum;
      const bool odd = wild_ && dice_.chance(0.2);
      if (odd) noteWild("shader parameters outside of their range");
      // Wide ranges are for experts: most numbers lie at their lower end.
      const double top = hasRange ? std::min(p.maximum, p.minimum + 10) : 1;
      const double value = odd ? oddNumber(dice_) : dice_.range(hasRange ? p.minimum : 0, top);
      if (p.type == "float")
        text += fmt::format(" \"float {}\" [{}]", p.name, number(value));
      else if (p.type == "int" && hasRange)
        text +=
            fmt::format(" \"int {}\" [{}]", p.name, static_cast<int>(dice_.range(p.minimum, top + 0.999)));
      else if (p.type == "color")
        text += fmt::format(
            " \"color {}\" {}", p.name,
            odd ? numbers(std::array{value, oddNumber(dice_), 0.5}) : triple(0, handle > 0 ? 1 : 0.85));
      else if (p.type == "point" || p.type == "vector" || p.type == "normal")
        text += fmt::format(" \"{} {}\" {}", p.type, p.name, triple(-2, 2));
      else if (p.type == "string" && odd)
        text += fmt::format(" \"string {}\" [\"no such file.tif\"]", p.name);
    }
    return text;
  }

  void lights() {
    int many = isSane_ ? 1 + dice_.below(3) : dice_.below(4);
    if (many == 0) note("no lights");
    for (; many > 0; --many) {
      const std::string_view kind =
          kLights[static_cast<size_t>(dice_.below(static_cast<int>(kLights.size())))];
      const auto found = std::ranges::find(library_, kind, &LibraryShader::name);
      if (found == library_.end()) continue;
      const std::string light = shader(*found, 10 + many);
      if (kind == "arealight") {
        ShapeNotes shapes;
        add("AttributeBegin\nAreaLightSource {}\n", light);
        transform();
        if (dice_.chance(0.5)) {
          add("Translate 0 2 0\nScale .5 .5 .5\n{}", randomShape(dice_, shapes));
          for (const std::string& what : shapes.ingredients) notes_.ingredients.insert("light: " + what);
        } else {
          const double r = dice_.pick({0.3, 1e-6, 0.8});
          if (r > 0.5) note("light inside of objects, objects inside of lights");
          add("Sphere {} {} {} 360\n", number(r), number(-r), number(r));
        }
        add("AttributeEnd\nIlluminate {} 1\n", 10 + many);
      } else {
        add("LightSource {}\n", light);
      }
    }
  }

  void transform() {
    switch (dice_.below(10)) {
      case 0:
        add("Scale 1 1 {}\n", number(dice_.pick({0.0, 1e-30, 1e-7}))), note("singular transformation");
        break;
      case 1:
        add("Scale -1 1 1\n"), note("mirrored transformation");
        break;
      case 2:
        add("Scale {0} {0} {0}\n", number(dice_.pick({1e-20, 1e-6, 1e6, 1e20}))), note("huge or tiny scale");
        break;
      case 3:
        add("Translate {} 0 0\n", number(dice_.pick({1e6, 1e30, 1e-40}))), note("far away");
        break;
      case 4:
        add("Skew {} 0 1 0 1 0 0\n", number(dice_.pick({30.0, 89.99, 90.0}))), note("strong skew");
        break;
      case 5:
        add("ConcatTransform [1 0 0 {} 0 1 0 0 0 0 1 0 0 0 0 1]\n", number(dice_.pick({0.1, 1.0}))),
            note("projective transformation of an object");
        break;
      default:
        add("Translate {} {} {}\nRotate {} 1 {} 0\n", number(dice_.range(-1, 1)), number(dice_.range(-1, 1)),
            number(dice_.range(-1, 1)), number(dice_.range(0, 360)), number(dice_.unit()));
    }
  }

  void attributes() {
    add("Color {}\n", triple(0, 0.9));
    if (dice_.chance(0.2)) add("Opacity {}\n", triple(0, 1)), note("transparency");
    if (wild_ && dice_.chance(0.2))
      add("Color [{} 2 -1]\n", number(oddNumber(dice_))), noteWild("odd colours");
    if (dice_.chance(0.2)) add("Sides {}\n", dice_.pick({1, 2}));
    if (dice_.chance(0.1)) add("ReverseOrientation\n");
    if (dice_.chance(0.2))
      // Values for areas of many pixels are other pictures, as is asked for.
      add("ShadingRate {}\n", number(isSane_ ? dice_.pick({0.05, 0.3, 1.0}) : dice_.pick({0.05, 25.0, 1e6}))),
          note("odd shading rate");
    if (dice_.chance(0.1))
      add("Attribute \"trace\" \"float bias\" [{}]\n", number(dice_.pick({0.0, 0.1, 1e-30}))),
          note("odd trace bias");
    if (dice_.chance(0.1))
      add("Attribute \"visibility\" \"int diffuse\" [0] \"int camera\" [{}]\n", dice_.below(2));
    if (!surfaces_.empty())
      add("Surface {}\n",
          shader(*surfaces_[static_cast<size_t>(dice_.below(static_cast<int>(surfaces_.size())))]));
    if (dice_.chance(0.2)) {
      const auto name =
          kDisplacements[static_cast<size_t>(dice_.below(static_cast<int>(kDisplacements.size())))];
      const auto found = std::ranges::find(library_, name, &LibraryShader::name);
      note("displacement");
      if (found != library_.end()) add("Displacement {}\n", shader(*found));
      if (dice_.chance(0.5))
        add("Attribute \"displacementbound\" \"float sphere\" [{}]\n",
            number(dice_.pick({0.0, 0.2, 1e10, -1.0})));
    }
  }

  void object() {
    add("AttributeBegin\n");
    attributes();
    const bool isInstance = dice_.chance(0.12);
    if (isInstance) {
      note("instances");
      add("ObjectBegin {}\n{}ObjectEnd\n", ++objects_, randomShape(dice_, notes_));
      for (int k = 0; k < 3; ++k) {
        add("AttributeBegin\n"), transform();
        add("ObjectInstance {}\nAttributeEnd\n", objects_);
      }
    } else if (dice_.chance(0.08)) {
      note("delayed archive");
      add("ArchiveBegin \"piece{}\"\n{}ArchiveEnd\n", ++archives_, randomShape(dice_, notes_));
      add("Procedural \"DelayedReadArchive\" [\"piece{}\"] [{}]\n", archives_,
          dice_.pick(
              {"-2 2 -2 2 -2 2", "0 0 0 0 0 0", "-1e30 1e30 -1e30 1e30 -1e30 1e30", "1 -1 1 -1 1 -1"}));
    } else {
      if (moves_ && dice_.chance(0.5)) {
        add("MotionBegin [0 1]\nRotate 0 0 1 0\nRotate {} 0 1 0\nMotionEnd\n", number(dice_.range(0, 90)));
        if (dice_.chance(0.2))
          add("MotionBegin [0 1]\nScale 1 1 1\nScale {} 1 1\nMotionEnd\n", dice_.pick({"0", "-1", "2"})),
              note("motion into the singular or the mirrored");
      }
      transform();
      if (moves_ && dice_.chance(0.4)) {
        add("MotionBegin [0 1]\n{}MotionEnd\n", randomShape(dice_, notes_, 2));
      } else {
        const std::string shape = randomShape(dice_, notes_);
        scene_.rib += shape;
        if (dice_.chance(0.15)) scene_.rib += shape, note("surfaces that coincide");
      }
    }
    add("AttributeEnd\n");
  }

  Dice dice_;
  const std::vector<LibraryShader>& library_;
  std::vector<const LibraryShader*> surfaces_;
  RandomScene scene_;
  ShapeNotes notes_;
  bool isSane_ = false, wild_ = false, moves_ = false;
  int objects_ = 0, archives_ = 0;
};

}  // namespace

RandomScene makeRandomScene(uint64_t number, const std::vector<LibraryShader>& library, RandomLight light) {
  return Maker(number, library, light).make();
}

}  // namespace patina::stress
