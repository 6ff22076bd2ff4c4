// Transform directives. pbrt's matrices are written column by column, as GLM stores them.

#include "framework/io/pbrt/reader.h"
#include "framework/io/text.h"

#include <fmt/format.h>

namespace etendue {

void PbrtReader::set_ctm(const Transform& transform, const Location& where) {
  const Transform inverse = transform.inverse();
  for (const Transform& t : {transform, inverse})
    if (!is_finite(t.point(vec3(0))) || !is_finite(t.vector(vec3(1))) || !is_finite(t.vector(vec3(1, -1, 0.5f))))
      throw Error(where, "the transforms together leave the range of single precision");
  attributes_.ctm = transform;
}

void PbrtReader::identity(PbrtLexer&, const Token&) { attributes_.ctm = Transform(); }

void PbrtReader::translate(PbrtLexer& lexer, const Token& token) {
  vec3 offset;
  for (int i = 0; i < 3; ++i) offset[i] = expect_number(lexer, "Translate");
  set_ctm(attributes_.ctm * Transform::translate(offset), lexer.where(token));
}

void PbrtReader::scale(PbrtLexer& lexer, const Token& token) {
  vec3 factors;
  for (int i = 0; i < 3; ++i) {
    const Location where = lexer.where(lexer.peek());
    factors[i] = expect_number(lexer, "Scale");
    if (factors[i] == 0) throw Error(where, "Scale: a factor of 0 has no inverse");
  }
  set_ctm(attributes_.ctm * Transform::scale(factors), lexer.where(token));
}

void PbrtReader::rotate(PbrtLexer& lexer, const Token& token) {
  const float degrees = expect_number(lexer, "Rotate");
  vec3 axis;
  for (int i = 0; i < 3; ++i) axis[i] = expect_number(lexer, "Rotate");
  const double length = glm::length(dvec3(axis));
  if (!(length > 0)) throw Error(lexer.where(token), "Rotate: the axis has no length");
  set_ctm(attributes_.ctm * Transform::rotate(degrees * (pi / 180), vec3(dvec3(axis) / length)), lexer.where(token));
}

void PbrtReader::look_at(PbrtLexer& lexer, const Token& token) {
  vec3 points[3];  // eye, target, up
  for (vec3& p : points)
    for (int i = 0; i < 3; ++i) p[i] = expect_number(lexer, "LookAt");
  const auto camera_to_world = Transform::look_at(points[0], points[1], points[2]);
  if (!camera_to_world) throw Error(lexer.where(token), "LookAt: the eye is the target, or up points along the view");
  set_ctm(attributes_.ctm * camera_to_world->inverse(), lexer.where(token));
}

Transform PbrtReader::read_matrix(PbrtLexer& lexer, const Token& token) const {
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
  const auto transform = Transform::from_matrix(m);
  if (!transform) throw Error(lexer.where(token), fmt::format("{}: the matrix has no inverse", name));
  return *transform;
}

void PbrtReader::transform(PbrtLexer& lexer, const Token& token) { set_ctm(read_matrix(lexer, token), lexer.where(token)); }

void PbrtReader::concat_transform(PbrtLexer& lexer, const Token& token) {
  set_ctm(attributes_.ctm * read_matrix(lexer, token), lexer.where(token));
}

void PbrtReader::coordinate_system(PbrtLexer& lexer, const Token&) {
  coordinate_systems_.insert_or_assign(expect_string(lexer, "CoordinateSystem"), attributes_.ctm);
}

void PbrtReader::coord_sys_transform(PbrtLexer& lexer, const Token&) {
  const Location where = lexer.where(lexer.peek());
  const std::string name = expect_string(lexer, "CoordSysTransform");
  const auto found = coordinate_systems_.find(name);
  if (found == coordinate_systems_.end()) {
    std::vector<std::string> names;
    for (const auto& [known, ctm] : coordinate_systems_) names.push_back(known);
    throw Error(where, unknown_name("coordinate system", name, names));
  }
  attributes_.ctm = found->second;
}

void PbrtReader::active_transform(PbrtLexer& lexer, const Token&) {
  const Token which = lexer.next();
  if (which.kind != TokenKind::word || which.text != "All")
    throw Error(lexer.where(which),
                fmt::format("ActiveTransform: expected All (nothing moves), found {}", lexer.describe(which)));
}

}  // namespace etendue
