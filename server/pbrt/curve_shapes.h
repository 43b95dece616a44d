// Converts Shape "curve" directives.
#pragma once

#include "server/pbrt/pbrt_shapes.h"

namespace lucerna::pbrt {

/// The curves of a Shape directive in world space.  Fails on invalid parameters.
CurveData make_curve(LoadState& context, const ShapeDirective& shape);

}  // namespace lucerna::pbrt
