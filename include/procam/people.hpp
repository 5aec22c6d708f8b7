#pragma once
/// Every public header of procam::people.
#include "procam/people/eye_safe.hpp"
#include "procam/people/interaction.hpp"
#include "procam/people/people.hpp"
#include "procam/people/silhouette.hpp"
#include "procam/people/skeleton.hpp"
#include "procam/people/skeleton_reader.hpp"
#include "procam/people/skeleton_source.hpp"
