#include "framework/io/pbrt/support.h"

#include <vector>

namespace etendue {

namespace {

constexpr std::string_view whole_or_mesh = "whole: as it is, under a transform that distorts it an instance; parts: a mesh",
                           uv_baked = "baked over (u, v)", place_baked = "baked by its place",
                           half_grey = "approximated: diffuse of 0.5";

constexpr PbrtSupport supported[] = {
    {"Camera", "perspective", "as it is, with lensradius; a screenwindow about the middle"},
    {"Camera", "orthographic", "as it is; approximated: without lensradius"},
    {"Camera", "spherical", "approximated: a perspective of 120 degrees around the middle of its image"},
    {"Camera", "environment", "like spherical"},
    {"Camera", "realistic", "approximated: a pinhole with the view of a 50 mm lens"},

    {"Shape", "trianglemesh", "as it is"},
    {"Shape", "plymesh",
     "a PLY, OBJ or SMF file; a PLY's faces of less than three vertices are left out (warned), quadrilaterals of "
     "version 4 that are bent, or show a texture or normals as two triangles do not, are two triangles (warned), its "
     "`tristrips` refused; approximated: without displacement"},
    {"Shape", "objmesh", "like plymesh"},
    {"Shape", "sphere", whole_or_mesh},
    {"Shape", "cylinder", whole_or_mesh},
    {"Shape", "disk", whole_or_mesh},
    {"Shape", "cone", "a mesh"},
    {"Shape", "paraboloid", "a mesh"},
    {"Shape", "hyperboloid", "a mesh"},
    {"Shape", "loopsubdiv", "the limit surface at levels splits, with normals of the limit mesh"},
    {"Shape", "curve", "ribbons and cylinders: meshes of 48 cells along each segment; flat ones approximated: tubes"},
    {"Shape", "bilinearmesh", "as it is where two triangles show the same; other patches have 16 x 16 cells"},
    {"Shape", "heightfield", "as it is"},
    {"Shape", "nurbs", "a mesh of 64 x 64 cells"},

    {"Material", "diffuse", "as it is"},
    {"Material", "matte", "as it is; with sigma approximated: diffuse with the albedo of [OrenNayar1994]"},
    {"Material", "mirror", "as it is"},
    {"Material", "conductor", "as it is"},
    {"Material", "metal", "as it is"},
    {"Material", "dielectric", "as it is; eta from 0.1 on"},
    {"Material", "glass", "as it is; eta from 0.1 on"},
    {"Material", "coateddiffuse",
     "plastic, warned: light between coat and base is summed in closed form; the coat absorbs by its thickness, and what "
     "scatters in it is approximated: it goes straight on"},
    {"Material", "plastic",
     "plastic, warned: as bright as Kd, seen straight on under even light; its coat reflects as much even light as in pbrt-v3, "
     "more straight on and less towards the edge"},
    {"Material", "uber",
     "plastic, warned: as bright as Kd, its coat reflecting its share straight on; with Kt alone glass; beside Kd or Ks "
     "approximated: without the diffuse part; opacity as it is where grey, else approximated: its mean"},
    {"Material", "substrate", "plastic, warned: as bright as Kd, its coat reflecting its share straight on"},
    {"Material", "mix",
     "of diffuse materials, and of two that are alike but for constant colours, as it is; of others approximated: the one with "
     "the larger share"},
    {"Material", "translucent",
     "as it is without Ks, else approximated: without highlights; of textures images alone, of others their mean"},
    {"Material", "none",
     "no surface; of a light, in version 3 one that emits and lets all rays through, in version 4 no light (warned)"},
    {"Material", "diffusetransmission", "like translucent"},
    {"Material", "interface", "like none"},
    {"Material", "subsurface", "approximated: plastic of the same albedo ([JensenMarschner2001])"},
    {"Material", "coatedconductor",
     "approximated: a conductor that reflects as much straight on, as rough as the rougher layer"},
    {"Material", "kdsubsurface", "like subsurface"},
    {"Material", "disney", "approximated: metal, rough glass, or a coated diffuse surface, whichever has most weight"},
    {"Material", "hair", "approximated: diffuse of its colour"},
    {"Material", "thindielectric", "as it is; eta from 0.1 on"},
    {"Material", "measured", half_grey},
    {"Material", "fourier", half_grey},

    {"Texture", "constant", "as it is"},
    {"Texture", "imagemap",
     "PNG, JPEG, TGA, HDR, PFM, EXR; over (u, v) as it is, by other mappings baked by its place; filter point "
     "interpolates over 1/16 of a texel at its edges, over more (warned) in images above 4096 texels; "
     "numbers in version 4 are the alpha of a PNG or EXR that is somewhere transparent, else the mean of the colours, in "
     "version "
     "3 their luminance before they are decoded"},
    {"Texture", "checkerboard", "of two colours over (u, v) as it is; else baked"},
    {"Texture", "scale", "by a constant as it is; else baked"},
    {"Texture", "mix", "of constants as it is; else baked"},
    {"Texture", "dots", uv_baked},
    {"Texture", "uv", uv_baked},
    {"Texture", "bilerp", uv_baked},
    {"Texture", "fbm", place_baked},
    {"Texture", "wrinkled", place_baked},
    {"Texture", "windy", place_baked},
    {"Texture", "marble", place_baked},
    {"Texture", "directionmix", place_baked},
    {"Texture", "ptex", "approximated: grey of 0.5"},

    {"LightSource", "point", "as it is; power"},
    {"LightSource", "spot", "as it is; power; under a transform that distorts approximated: a round cone"},
    {"LightSource", "distant", "as it is; illuminance"},
    {"LightSource", "infinite", "constant, equirectangular or octahedral; a portal approximated: light from everywhere"},
    {"LightSource", "goniometric", "approximated: a point light of the same power; power"},
    {"LightSource", "projection", "approximated: a spot over the same solid angle; power"},
    {"AreaLightSource", "diffuse", "as it is, with filename; on shapes of an object approximated: none, as in pbrt"},
    {"AreaLightSource", "area", "like diffuse"},
};

}  // namespace

std::span<const PbrtSupport> pbrt_support() { return supported; }

void require_known(std::string_view directive, std::string_view kind, const std::string& type, const Location& where) {
  std::vector<std::string> names;
  for (const PbrtSupport& row : supported) {
    if (row.directive != directive) continue;
    if (row.type == type) return;
    names.emplace_back(row.type);
  }
  throw Error(where, unknown_name(kind, type, names));
}

}  // namespace etendue
