// SPDX-License-Identifier: Apache-2.0
// Lobes: RI's specular(), GGX reflection and rough dielectrics (Walter et al. 2007; Heitz 2014 and 2018), and
// those that plugins bring.
#include "renderer/shading/bsdf.h"

#include "patina/shader.h"
#include "renderer/base/sampling.h"
#include "renderer/shading/custom_lobe.h"

namespace patina {
namespace {

constexpr float kSmoothAlpha =
    1e-3f;  // below, a lobe counts as a mirror: its density would exceed what floats hold
constexpr float kMatchedIndex = 1e-4f;  // nearer to 1, a boundary bends no ray, however rough it is

float ggxD(const V3f& h, float alpha) {
  // As a sum of squares: 1 - h.z^2 would have lost the digits of a small alpha's narrow peak.
  const float a2 = alpha * alpha, d = a2 * h.z * h.z + (h.x * h.x + h.y * h.y);
  return h.z > 0 ? a2 / (kPi * d * d) : 0;
}
float ggxLambda(const V3f& w, float alpha) {
  const float c2 = w.z * w.z, s2 = std::max(0.0f, 1 - c2);
  return c2 > 0 ? (std::sqrt(1 + alpha * alpha * s2 / c2) - 1) / 2 : kInfinity;
}
float ggxG1(const V3f& w, float alpha) { return 1 / (1 + ggxLambda(w, alpha)); }
/// Height-correlated masking and shadowing, both directions on the same side.
float ggxG2(const V3f& a, const V3f& b, float alpha) {
  return 1 / (1 + ggxLambda(a, alpha) + ggxLambda(b, alpha));
}

/// Visible normals (Heitz 2018, "Sampling the GGX Distribution of Visible Normals").
V3f sampleVisibleNormal(const V3f& w, float alpha, const V2f& u) {
  const V3f v = V3f(alpha * w.x, alpha * w.y, w.z).normalized();
  const float squared = v.x * v.x + v.y * v.y;
  const V3f t1 = squared > 0 ? V3f(-v.y, v.x, 0) / std::sqrt(squared) : V3f(1, 0, 0);
  const V3f t2 = v.cross(t1);
  const float r = std::sqrt(u.x), phi = 2 * kPi * u.y;
  const float p1 = r * std::cos(phi), s = 0.5f * (1 + v.z);
  const float p2 = (1 - s) * std::sqrt(std::max(0.0f, 1 - p1 * p1)) + s * r * std::sin(phi);
  const V3f n = t1 * p1 + t2 * p2 + v * std::sqrt(std::max(0.0f, 1 - p1 * p1 - p2 * p2));
  return V3f(alpha * n.x, alpha * n.y, std::max(1e-6f, n.z)).normalized();
}
float visibleNormalPdf(const V3f& w, const V3f& h, float alpha) {
  return w.z > 0 ? ggxG1(w, alpha) * std::max(0.0f, w.dot(h)) * ggxD(h, alpha) / w.z : 0;
}

bool refract(const V3f& w, const V3f& n, float eta, V3f& out) {  // w and n on the same side; eta = n_t / n_i
  const float c = w.dot(n);
  const float sin2t = (1 - c * c) / (eta * eta);
  if (sin2t >= 1) return false;
  out = -w / eta + n * (c / eta - std::sqrt(1 - sin2t));
  return true;
}

bool isDelta(const Lobe& lobe) {
  return lobe.type != PATINA_LOBE_RI_SPECULAR && !lobe.custom &&
         (lobe.alpha < kSmoothAlpha ||
          (lobe.type == PATINA_LOBE_DIELECTRIC && std::abs(lobe.eta - 1) < kMatchedIndex));
}

/// Exponent of RI's specular(). RI 3.2 leaves it open; 8/roughness is what Aqsis and Pixie have, and pictures
/// expect.
float exponent(const Lobe& lobe) { return 8 / std::max(lobe.alpha, 1e-4f); }

/// As alpha of GGX.
float widthOf(const Lobe& lobe) {
  return lobe.type == PATINA_LOBE_RI_SPECULAR ? std::sqrt(2 / (exponent(lobe) + 2))
                                              : std::min(lobe.alpha, 1.0f);
}

}  // namespace

float fresnelDielectric(float cosine, float eta) {
  cosine = std::clamp(cosine, 0.0f, 1.0f);
  const float sin2t = (1 - cosine * cosine) / (eta * eta);
  if (sin2t >= 1) return 1;
  const float cosT = std::sqrt(1 - sin2t);
  const float parallel = (eta * cosine - cosT) / (eta * cosine + cosT);
  const float perpendicular = (cosine - eta * cosT) / (cosine + eta * cosT);
  return (parallel * parallel + perpendicular * perpendicular) / 2;
}

Bsdf::Bsdf(const ShadingPoint& point, const SurfaceTerms& terms, std::span<const Lobe> lobes)
    : point_(point), terms_(terms), lobes_(lobes), wo_(-point.I), frame_(point.N) {
  // A shading normal that faces away from the viewer would reflect into the surface: bend it to the horizon.
  const float facing = wo_.dot(point.N);
  if (!lobes.empty() && facing < 1e-3f)
    frame_ = Frame(normalizedOr(point.N + wo_ * (1e-3f - facing), point.Ng));
  reflectChance_ = luminance(terms.reflectance);
  transmitChance_ = luminance(terms.transmittance);
  total_ = reflectChance_ + transmitChance_;
  for (const Lobe& lobe : lobes) total_ += lobeChance(lobe);
}

float Bsdf::lobeChance(const Lobe& lobe) const {
  return std::max(luminance(lobe.weight), luminance(lobe.transmission));
}

bool Bsdf::scattersSmoothly(bool withDiffuse) const {
  if (withDiffuse && reflectChance_ + transmitChance_ > 0) return true;
  return std::any_of(lobes_.begin(), lobes_.end(), [](const Lobe& lobe) { return !isDelta(lobe); });
}

bool Bsdf::transmits() const {
  if (!patina::isBlack(terms_.transmittance)) return true;
  return std::any_of(lobes_.begin(), lobes_.end(), [](const Lobe& lobe) {
    return lobe.type == PATINA_LOBE_DIELECTRIC || (lobe.custom && lobe.custom->lobe->transmits());
  });
}

float Bsdf::cosineAt(const V3f& wi, bool deltaLight) const {
  const float side = wi.dot(point_.Ng) > 0 ? 1.0f : -1.0f;
  return deltaLight ? std::max(side * wi.dot(point_.N), 0.0f)
                    : foldedCosine(wi, point_.N * side, point_.Ng * side);
}

Rgb Bsdf::diffuseAt(const V3f& wi, bool deltaLight) const {
  return (wi.dot(point_.Ng) > 0 ? terms_.reflectance : terms_.transmittance) *
         (cosineAt(wi, deltaLight) * kInvPi);
}

Bsdf::Value Bsdf::evaluate(const V3f& wi, bool withDiffuse, bool deltaLight) const {
  Value value;
  const float all = withDiffuse ? total_ : total_ - reflectChance_ - transmitChance_;
  if (!(all > 0)) return value;
  const bool reflected = wi.dot(point_.Ng) > 0;
  if (withDiffuse) {
    const float cosine = cosineAt(wi, deltaLight);
    value.f += diffuseAt(wi, deltaLight);
    value.pdf += (reflected ? reflectChance_ : transmitChance_) * cosine * kInvPi;
  }
  const V3f o = frame_.toLocal(wo_), i = frame_.toLocal(wi);
  for (const Lobe& lobe : lobes_) {
    if (isDelta(lobe)) continue;
    const float chance = lobeChance(lobe);
    if (lobe.type == PATINA_LOBE_RI_SPECULAR) {
      if (!reflected || i.z <= 0) continue;
      const V3f h = (o + i).normalized();
      const float n = exponent(lobe), power = std::pow(std::max(h.z, 0.0f), n);
      value.f += lobe.weight * (power * kInvPi);
      // Half vectors are drawn with density (n+1)/(2 pi) cos^n.
      const float oh = o.dot(h);
      if (oh > 0) value.pdf += chance * (n + 1) / (2 * kPi) * power / (4 * oh);
      continue;
    }
    if (lobe.custom) {
      const CustomLobe& custom = *lobe.custom->lobe;
      const bool asked = reflected ? i.z > 0 && custom.reflects() : i.z < 0 && custom.transmits();
      if (!asked || o.z <= 0) continue;
      const CustomLobe::Value v = custom.evaluate(customAt(lobe), wi);
      value.f += lobe.weight * v.f;
      value.pdf += chance * v.pdf;
      continue;
    }
    const float alpha = lobe.alpha;
    if (reflected && i.z > 0 && o.z > 0) {
      const V3f h = (o + i).normalized();
      const float f = lobe.type == PATINA_LOBE_DIELECTRIC ? fresnelDielectric(o.dot(h), lobe.eta) : 1;
      value.f += lobe.weight * (f * ggxD(h, alpha) * ggxG2(o, i, alpha) / (4 * o.z));
      const float select = lobe.type == PATINA_LOBE_DIELECTRIC ? f : 1;
      value.pdf += chance * select * visibleNormalPdf(o, h, alpha) / (4 * std::max(o.dot(h), 1e-12f));
    } else if (!reflected && i.z < 0 && o.z > 0 && lobe.type == PATINA_LOBE_DIELECTRIC) {
      // Generalised half vector on the side of the viewer (Walter et al. 2007, section 4.2).
      V3f h = -(o + i * lobe.eta);
      h = normalizedOr(h, V3f(0, 0, 1));
      if (h.z < 0) h = -h;
      const float oh = o.dot(h), ih = i.dot(h);
      if (oh <= 0 || ih >= 0) continue;
      const float f = fresnelDielectric(oh, lobe.eta);
      const float denominator = oh + lobe.eta * ih;
      const float jacobian = lobe.eta * lobe.eta * -ih / (denominator * denominator);
      const V3f below(i.x, i.y, -i.z);
      // Radiance is compressed by 1/eta^2 on its way in (PBR 4th ed. section 9.5.2).
      value.f += lobe.transmission * ((1 - f) * ggxD(h, alpha) * ggxG2(o, below, alpha) * oh * jacobian /
                                      (o.z * lobe.eta * lobe.eta));
      value.pdf += chance * (1 - f) * visibleNormalPdf(o, h, alpha) * jacobian;
    }
  }
  value.pdf /= all;
  if (!std::isfinite(value.pdf) || !isFinite(value.f)) return {};
  return value;
}

BsdfSample Bsdf::sample(float choice, const V2f& random, bool withDiffuse) const {
  BsdfSample s;
  const float diffuse = withDiffuse ? reflectChance_ + transmitChance_ : 0;
  const float all = withDiffuse ? total_ : total_ - reflectChance_ - transmitChance_;
  if (!(all > 0)) return s;
  float x = choice * all, rest = 0;  // of the choice, uniform in [0, 1) again
  if (x < diffuse) {
    const bool through = x >= reflectChance_;
    rest = through ? (x - reflectChance_) / transmitChance_ : x / reflectChance_;
    const Frame frame(through ? -point_.N : point_.N);
    s.direction =
        foldDirection(frame.toWorld(sampleCosineHemisphere(random)), through ? -point_.Ng : point_.Ng);
    s.diffuse = true, s.transmitted = through;
    s.alpha = 1;
  } else {
    x -= diffuse;
    const Lobe* lobe = lobes_.data();
    while (lobe + 1 < lobes_.data() + lobes_.size() && x >= lobeChance(*lobe)) x -= lobeChance(*lobe), ++lobe;
    const float chance = lobeChance(*lobe);
    const float select = std::clamp(x / chance, 0.0f, kOneMinusEpsilon);
    rest = select;
    const V3f o = frame_.toLocal(wo_);
    if (lobe->custom) {
      if (o.z <= 0 || !lobe->custom->lobe->sample(customAt(*lobe), random, s.direction)) return s;
      s.transmitted = s.direction.dot(frame_.z) < 0;
      s.alpha = widthOf(*lobe);
      if ((s.direction.dot(point_.Ng) > 0) == s.transmitted) return s;
      return weighed(s, withDiffuse, rest);
    }
    s.alpha = widthOf(*lobe);
    V3f h(0, 0, 1);
    if (lobe->type == PATINA_LOBE_RI_SPECULAR) {
      const float c = std::pow(random.x, 1 / (exponent(*lobe) + 1)), r = std::sqrt(std::max(0.0f, 1 - c * c));
      h = {r * std::cos(2 * kPi * random.y), r * std::sin(2 * kPi * random.y), c};
    } else if (!isDelta(*lobe)) {
      if (o.z <= 0) return s;
      h = sampleVisibleNormal(o, lobe->alpha, random);
    }
    const float oh = o.dot(h);
    if (oh <= 0) return s;
    V3f i = h * (2 * oh) - o;
    float fraction = 1;  // of the lobe's chance that this branch took
    if (lobe->type == PATINA_LOBE_DIELECTRIC) {
      const float f = fresnelDielectric(oh, lobe->eta);
      s.transmitted = select >= f;
      fraction = s.transmitted ? 1 - f : f;
      rest = (s.transmitted ? select - f : select) / fraction;
      if (s.transmitted && !refract(o, h, lobe->eta, i)) return s;
    }
    s.direction = frame_.toWorld(i).normalized();
    if ((s.direction.dot(point_.Ng) > 0) == s.transmitted) return s;
    if (isDelta(*lobe)) {
      // Fresnel in f and in the choice cancel; refraction compresses radiance.
      s.weight = s.transmitted ? lobe->transmission / (lobe->eta * lobe->eta) : lobe->weight;
      s.weight *= all / chance;
      s.pdf = fraction > 0 ? 1 : 0;
      s.delta = true;
      return s;
    }
  }
  return weighed(s, withDiffuse, rest);
}

CustomLobe::At Bsdf::customAt(const Lobe& lobe) const {
  return {*lobe.custom, frame_.z, wo_, lobe.alpha, lobe.eta, point_.P};
}

/// The sample with the density of its direction by all lobes. Whichever lobe it was drawn by: whether it is a
/// diffuse or a specular bounce is chosen, by u, by what they scatter there, and it carries the share of that
/// kind. So the light of each kind is what its lobes say where one of them may go no further.
BsdfSample Bsdf::weighed(BsdfSample s, bool withDiffuse, float u) const {
  const Value value = evaluate(s.direction, withDiffuse, false);
  if (!(value.pdf > 0)) return s;
  s.pdf = value.pdf;
  s.weight = value.f / value.pdf;
  if (!withDiffuse || lobes_.empty()) return s;
  const Rgb diffuse = diffuseAt(s.direction, false);
  const float share = std::clamp(luminance(diffuse) / luminance(value.f), 0.0f, 1.0f);
  if (!(share < 1)) return s;
  const bool wasDiffuse = std::exchange(s.diffuse, u < share);
  s.weight = s.diffuse ? diffuse / (value.pdf * share) : (value.f - diffuse) / (value.pdf * (1 - share));
  if (s.diffuse) {
    s.alpha = 1;
  } else if (wasDiffuse) {
    s.alpha = 0;
    for (const Lobe& lobe : lobes_)
      if (!isDelta(lobe)) s.alpha = std::max(s.alpha, widthOf(lobe));
  }
  return s;
}

}  // namespace patina
