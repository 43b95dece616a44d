// The list of all lights with a surface.
#pragma once

#include "lights/models/all_lights.h"

namespace lucerna::testing {

template <typename First, typename... Lights>
using ListWithoutFirst = LightList<Lights...>;

#define LUCERNA_LIGHT(Shape) , Shape##Light
#define LUCERNA_PAINTED_LIGHT(Shape) , Painted##Shape##Light
#define LUCERNA_PANEL_LIGHT(Shape) , Panel##Shape##Light
/// Each shape as a light and with a picture on it, and each that can be flat as a panel.
using AreaLights = ListWithoutFirst<void LUCERNA_AREA_SHAPES(LUCERNA_LIGHT) LUCERNA_AREA_SHAPES(
    LUCERNA_PAINTED_LIGHT) LUCERNA_FLAT_SHAPES(LUCERNA_PANEL_LIGHT)>;
#undef LUCERNA_LIGHT
#undef LUCERNA_PAINTED_LIGHT
#undef LUCERNA_PANEL_LIGHT

}  // namespace lucerna::testing
