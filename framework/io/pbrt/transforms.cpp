// Transform directives. pbrt's matrices are written column by column, as GLM stores them.

#include "framework/io/pbrt/reader.h"
#include "framework/io/text.h"

#include <fmt/format.h>

namespace etendue {

const Transform& PbrtReader::ctm() const {
  const Placement& placement = attributes_.ctm;
  if (placement.singular) throw Error(placement.singular->where, placement.singular->why);
  return placement.transform;
}

void PbrtReader::replace(const Placement& placement) {
  if (!attributes_.end_only) attributes_.ctm = placement;
}

void PbrtReader::set_ctm(const Transform& transform, const Location& where) {
  const Transform inverse = transform.inverse();
  for (const Transform& t : {transform, inverse})
    if (!is_finite(t.point(vec3(0))) || !is_finite(t.vector(vec3(1))) || !is_finite(t.vector(vec3(1, -1, 0.5f))))
      throw Error(where, "the transforms together leave the range of single precision");
  replace({transform, std::nullopt});
}

// What has no inverse matters only once something is placed by it.
void PbrtReader::compose(const std::optional<Transform>& inner, const Location& where, const std::string& why_not) {
  if (attributes_.ctm.singular) return;
  if (inner)
    set_ctm(attributes_.ctm.transform * *inner, where);
  else
    replace({attributes_.ctm.transform, Singular{where, why_not}});
}

void PbrtReader::identity(PbrtLexer&, const Token&) { replace({}); }

void PbrtReader::translate(PbrtLexer& lexer, const Token& token) {
  vec3 offset;
  for (int i = 0; i < 3; ++i) offset[i] = expect_number(lexer, "Translate");
  compose(Transform::translate(offset), lexer.where(token), "");
}

void PbrtReader::scale(PbrtLexer& lexer, const Token& token) {
  vec3 factors;
  std::optional<Location> zero;
  for (int i = 0; i < 3; ++i) {
    const Location where = lexer.where(lexer.peek());
    factors[i] = expect_number(lexer, "Scale");
    if (factors[i] == 0 && !zero) zero = where;
  }
  compose(zero ? std::nullopt : std::optional(Transform::scale(factors)), zero.value_or(lexer.where(token)),
          "Scale: a factor of 0 has no inverse");
}

void PbrtReader::rotate(PbrtLexer& lexer, const Token& token) {
  const float degrees = expect_number(lexer, "Rotate");
  vec3 axis;
  for (int i = 0; i < 3; ++i) axis[i] = expect_number(lexer, "Rotate");
  const double length = glm::length(dvec3(axis));
  compose(length > 0 ? std::optional(Transform::rotate(degrees * (pi / 180), vec3(dvec3(axis) / length))) : std::nullopt,
          lexer.where(token), "Rotate: the axis has no length");
}

void PbrtReader::look_at(PbrtLexer& lexer, const Token& token) {
  vec3 points[3];  // eye, target, up
  for (vec3& p : points)
    for (int i = 0; i < 3; ++i) p[i] = expect_number(lexer, "LookAt");
  const auto camera_to_world = Transform::look_at(points[0], points[1], points[2]);
  compose(camera_to_world ? std::optional(camera_to_world->inverse()) : std::nullopt, lexer.where(token),
          "LookAt: the eye is the target, or up points along the view");
}

std::optional<Transform> PbrtReader::read_matrix(PbrtLexer& lexer, const Token& token) const {
  const std::string name(token.text);
  const bool bracketed = lexer.peek().kind == TokenKind::open;
  if (bracketed) lexer.next();
  glm::mat4 m;
  for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = expect_number(lexer, name);
  if (bracketed)
    if (const Token close = lexer.next(); close.kind != TokenKind::close)
      throw Error(lexer.where(close), fmt::format("{}: expected ] after 16 numbers, found {}", name, lexer.describe(close)));
  for (int i = 0; i < 4; ++i) {
    const float affine = i < 3 ? 0 : 1;
    if (std::abs(m[i][3] - affine) > 1e-6f)
      throw Error(lexer.where(token),
                  fmt::format("{}: the matrix is not affine; its 4th, 8th, 12th and 16th numbers must be 0 0 0 1", name));
    m[i][3] = affine;
  }
  return Transform::from_matrix(m);
}

void PbrtReader::transform(PbrtLexer& lexer, const Token& token) {
  const auto matrix = read_matrix(lexer, token);
  replace({});
  compose(matrix, lexer.where(token), "Transform: the matrix has no inverse");
}

void PbrtReader::concat_transform(PbrtLexer& lexer, const Token& token) {
  const auto matrix = read_matrix(lexer, token);
  compose(matrix, lexer.where(token), "ConcatTransform: the matrix has no inverse");
}

void PbrtReader::coordinate_system(PbrtLexer& lexer, const Token&) {
  coordinate_systems_.insert_or_assign(expect_string(lexer, "CoordinateSystem"), CoordinateSystem{attributes_.ctm, import_});
}

void PbrtReader::coord_sys_transform(PbrtLexer& lexer, const Token&) {
  const Location where = lexer.where(lexer.peek());
  const std::string name = expect_string(lexer, "CoordSysTransform");
  const auto found = coordinate_systems_.find(name);
  if (found == coordinate_systems_.end()) {
    std::vector<std::string> names;
    for (const auto& [known, system] : coordinate_systems_) names.push_back(known);
    throw Error(where, unknown_name("coordinate system", name, names));
  }
  if (found->second.of_import != import_)
    warn(where,
         fmt::format("CoordSysTransform: '{}' is named on the other side of an Import; it counts, but not in pbrt-v4", name));
  attributes_.ctm = found->second.ctm;  // whichever transform is active
}

void PbrtReader::active_transform(PbrtLexer& lexer, const Token&) {
  const Token which = lexer.next();
  const bool known = which.text == "All" || which.text == "StartTime" || which.text == "EndTime";
  if (which.kind != TokenKind::word || !known)
    throw Error(lexer.where(which),
                fmt::format("ActiveTransform: expected All, StartTime or EndTime, found {}", lexer.describe(which)));
  if (which.text != "All")
    approximate(lexer.where(which), "ActiveTransform: nothing moves", "the place at the start time, without blur");
  attributes_.end_only = which.text == "EndTime";
}

void PbrtReader::transform_times(PbrtLexer& lexer, const Token&) {
  for (int i = 0; i < 2; ++i) expect_number(lexer, "TransformTimes");
}

}  // namespace etendue
