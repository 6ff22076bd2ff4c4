// Products of errors, found from images while there are images: with the log they are all that squared bias and variance need.
#pragma once

#include "experiments/log/log.h"
#include "framework/image/film.h"

#include <span>
#include <string>
#include <vector>

namespace etendue {

// G_ij of the images of several seeds (ProductsRecord), over pixels of the reference; those of the images begin at `first`.
std::vector<double> error_products(std::span<const Image> images, const Image& reference, std::span<const std::size_t> pixels,
                                   std::size_t first = 0);

// The products of a configuration, where the log has them of the very images that it names; null otherwise.
const ProductsRecord* current_products(const RunLog& log, const CellName& configuration, const std::string& region,
                                       bool at_checkpoints);

// The products that the log lacks and the images that it names allow (their paths found from here): of each configuration with
// two seeds or more the whole image at its end, and where the images of all checkpoints were kept, the whole image and every
// region there. Configurations whose images cannot be read, or are not of one size, are left out.
std::vector<ProductsRecord> missing_products(const RunLog& log);

}  // namespace etendue
