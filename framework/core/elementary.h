// Elementary functions that have the same bits on every processor and with every C library.
//
// The functions of C libraries differ in their last bits from one library to the next, and in one library between processors
// with fused multiplication and without. These are SLEEF's deterministic ones, without it ([Shibata2020]). Errors are at most
// 3.5 units in the last place; for exp, expm1, log1p, pow, asinh and lgamma one unit. The test `House.ElementaryFunctionsAreOurs`
// finds calls of the C library's.
#pragma once

namespace etendue::math {

float sin(float x);
float cos(float x);
float tan(float x);
float asin(float x);
float acos(float x);
float atan(float x);
float atan2(float y, float x);
float exp(float x);
float exp2(float x);
float log(float x);
float log2(float x);
float pow(float x, float y);
float hypot(float x, float y);

double sin(double x);
double cos(double x);
double tan(double x);
double asin(double x);
double acos(double x);
double atan(double x);
double atan2(double y, double x);
double exp(double x);
double exp2(double x);
double expm1(double x);
double log(double x);
double log2(double x);
double log1p(double x);
double pow(double x, double y);
double cbrt(double x);
double hypot(double x, double y);
double sinh(double x);
double cosh(double x);
double asinh(double x);
double lgamma(double x);

}  // namespace etendue::math
