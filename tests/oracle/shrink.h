// Finds the smallest scene that has the same fault.
#pragma once

#include <functional>
#include <utility>

#include "tests/oracle/oracle_question.h"

namespace lucerna::oracle {

/// Leaves out shapes and lights, motion, pictures and digits, as long as `fails`.
std::pair<World, Question> shrink(
    World world, Question question,
    const std::function<bool(const World& world, const Question& question)>& fails);

}  // namespace lucerna::oracle
