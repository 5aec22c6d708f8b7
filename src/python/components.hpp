#pragma once
/// One function for each component; they are called in this order, as signatures name types bound before.
#include <pybind11/pybind11.h>

namespace procam::python {

void bind_core_base(pybind11::module_& m);
void bind_core_pose(pybind11::module_& m);
void bind_core_geometry(pybind11::module_& m);
void bind_core_lens(pybind11::module_& m);
void bind_core_board(pybind11::module_& m);
void bind_core_rig(pybind11::module_& m);
void bind_core_surface(pybind11::module_& m);
void bind_pattern(pybind11::module_& m);
void bind_io(pybind11::module_& m);
void bind_io_exchange(pybind11::module_& m);
void bind_detect(pybind11::module_& m);
void bind_surface(pybind11::module_& m);
void bind_calibrate_bundle(pybind11::module_& m);
void bind_calibrate(pybind11::module_& m);
void bind_render(pybind11::module_& m);
void bind_track(pybind11::module_& m);
void bind_track_surfaces(pybind11::module_& m);
void bind_track_wire(pybind11::module_& m);
void bind_simulate(pybind11::module_& m);
void bind_simulate_room(pybind11::module_& m);
void bind_simulate_live(pybind11::module_& m);
void bind_simulate_robot(pybind11::module_& m);
void bind_session_views(pybind11::module_& m);
void bind_session(pybind11::module_& m);
void bind_scan(pybind11::module_& m);
void bind_room(pybind11::module_& m);
void bind_depth(pybind11::module_& m);
void bind_depth_heights(pybind11::module_& m);
void bind_analyze(pybind11::module_& m);
void bind_analyze_projection(pybind11::module_& m);
void bind_report(pybind11::module_& m);
void bind_show(pybind11::module_& m);
void bind_show_frames(pybind11::module_& m);
void bind_people(pybind11::module_& m);
void bind_watch(pybind11::module_& m);
void bind_mount(pybind11::module_& package);
void bind_update(pybind11::module_& package);

}  // namespace procam::python
