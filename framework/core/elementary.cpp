#include "framework/core/elementary.h"

#include <sleef.h>

namespace etendue::math {

float sin(float x) { return Sleef_cinz_sinf1_u35purec(x); }
float cos(float x) { return Sleef_cinz_cosf1_u35purec(x); }
float tan(float x) { return Sleef_cinz_tanf1_u35purec(x); }
float asin(float x) { return Sleef_cinz_asinf1_u35purec(x); }
float acos(float x) { return Sleef_cinz_acosf1_u35purec(x); }
float atan(float x) { return Sleef_cinz_atanf1_u35purec(x); }
float atan2(float y, float x) { return Sleef_cinz_atan2f1_u35purec(y, x); }
float exp(float x) { return Sleef_cinz_expf1_u10purec(x); }
float exp2(float x) { return Sleef_cinz_exp2f1_u35purec(x); }
float log(float x) { return Sleef_cinz_logf1_u35purec(x); }
float log2(float x) { return Sleef_cinz_log2f1_u35purec(x); }
// SLEEF's own takes three times as long.
float pow(float x, float y) {
  return y == 0 ? 1 : static_cast<float>(exp(static_cast<double>(y) * log(static_cast<double>(x))));
}
float hypot(float x, float y) { return Sleef_cinz_hypotf1_u35purec(x, y); }

double sin(double x) { return Sleef_cinz_sind1_u35purec(x); }
double cos(double x) { return Sleef_cinz_cosd1_u35purec(x); }
double tan(double x) { return Sleef_cinz_tand1_u35purec(x); }
double asin(double x) { return Sleef_cinz_asind1_u35purec(x); }
double acos(double x) { return Sleef_cinz_acosd1_u35purec(x); }
double atan(double x) { return Sleef_cinz_atand1_u35purec(x); }
double atan2(double y, double x) { return Sleef_cinz_atan2d1_u35purec(y, x); }
double exp(double x) { return Sleef_cinz_expd1_u10purec(x); }
double exp2(double x) { return Sleef_cinz_exp2d1_u35purec(x); }
double expm1(double x) { return Sleef_cinz_expm1d1_u10purec(x); }
double log(double x) { return Sleef_cinz_logd1_u35purec(x); }
double log2(double x) { return Sleef_cinz_log2d1_u35purec(x); }
double log1p(double x) { return Sleef_cinz_log1pd1_u10purec(x); }
double pow(double x, double y) { return Sleef_cinz_powd1_u10purec(x, y); }
double cbrt(double x) { return Sleef_cinz_cbrtd1_u35purec(x); }
double hypot(double x, double y) { return Sleef_cinz_hypotd1_u35purec(x, y); }
double sinh(double x) { return Sleef_cinz_sinhd1_u35purec(x); }
double cosh(double x) { return Sleef_cinz_coshd1_u35purec(x); }
double asinh(double x) { return Sleef_cinz_asinhd1_u10purec(x); }
double lgamma(double x) { return Sleef_cinz_lgammad1_u10purec(x); }

}  // namespace etendue::math
