#!/usr/bin/env bash
# Renders every built-in scene into docs/images/gallery/, as docs/gallery.md shows them, and where methods fail into
# docs/images/methods/, as docs/methods.md does. It takes some minutes.
#
#   docs/pictures.sh [PICTURE…]     all of them, or those: gallery/edge methods/ppm
#
# ETENDUE=build/etendue names another program than the launcher.
set -euo pipefail
cd "$(dirname "$0")/.."

# Each scene with its size, and the method and the iterations that leave no noise to be seen; then pictures with a name of their own.
pictures='
cornell-box                144x144  path             1024
cornell-spheres            144x144  vcm              512
glass-caustic              192x144  vcm              192
two-rooms                  192x144  photon-cache     16
veach-mis                  192x128  path             256
glossy-cornell-box         144x144  path             512
keyhole                    144x144  photon-cache     48
exterior                   144x144  path             256
mesh                       144x144  path             256
mesh-large                 144x144  path             128
stadium                    144x144  path             256
lambert-sphere             128x128  path             64
lambert-sphere-off-centre  128x128  path             64
furnace                    128x128  path             16
white-furnace              128x128  path             128
polygon-light              128x128  path             64
sphere-light               128x128  path             64
disc-light                 128x128  path             64
cavity                     128x128  path             128
concentric-spheres         128x128  path             64
mirror                     128x128  sppm             64
water                      128x128  sppm             64
edge                       128x128  sppm             64
corner                     128x128  sppm             64
thin-plate                 128x128  path             128
broad-light                128x128  path             128
two-occluders              128x128  path             128
glowing-room               128x128  path             256
hidden-occluder            128x128  sppm             64
slit-light                 128x128  sppm             64
thin-wall                  128x128  path             256
black-surroundings         128x128  path             512
many-lights                192x128  path             128
sunlit-field               128x128  sppm             64
sunlit-ball                128x128  sppm             64
far-kerb                   128x128  path             64
veiled-lamp                128x128  sppm             256
many-lamps                 128x128  path             64
glossy-furnace             128x128  path             64
glossy-lamp                128x128  path             128
coincident                 128x128  path             64
slivers                    128x128  path             64
overlap                    128x128  path             64
cornell-spheres            144x144  light-trace      256   methods/light-trace
cornell-spheres            144x144  ppm              128   methods/ppm
water?camera=above         128x128  sppm             64    methods/water-above
water?camera=above         128x128  bdpt             32    methods/bdpt
keyhole                    144x144  hash-cache       8     methods/hash-cache
'
mkdir -p docs/images/gallery docs/images/methods
while read -r scene size method iterations picture; do
  [ -n "$scene" ] || continue
  picture=${picture:-gallery/$scene}
  [ $# = 0 ] || [[ " $* " = *" $picture "* ]] || continue
  "${ETENDUE:-./etendue}" render "builtin:$scene" -i "$method" --spp "$iterations" --resolution "$size" \
    -o "docs/images/$picture.png" </dev/null
done <<<"$pictures"
