#pragma once
/// All targets. A new one is a function here, a row in targets.cpp, and a folder of inputs in corpus/.
#include <string_view>

namespace procam::fuzz {

// Documents: the syntaxes below all other files (documents.cpp).
void json(std::string_view bytes);
void xml(std::string_view bytes);
void yaml(std::string_view bytes);

// procam's own files; *_fields: a valid document with drawn changes (own_files.cpp, changed_files.cpp).
void rig(std::string_view bytes);
void rig_fields(std::string_view bytes);
void surfaces_json(std::string_view bytes);
void surfaces_xml(std::string_view bytes);
void surfaces_fields(std::string_view bytes);
void solved_surfaces(std::string_view bytes);
void show(std::string_view bytes);
void show_fields(std::string_view bytes);
void session(std::string_view bytes);
void board(std::string_view bytes);
void markers(std::string_view bytes);
void pose(std::string_view bytes);
void pattern(std::string_view bytes);
void shown(std::string_view bytes);
void typed(std::string_view bytes);

// What other programs write (exchange.cpp, arrays.cpp, tables.cpp).
void calibration(std::string_view bytes);
void mpcdi(std::string_view bytes);
void mesh_obj(std::string_view bytes);
void mesh_ply(std::string_view bytes);
void pfm(std::string_view bytes);
void npy(std::string_view bytes);
void image(std::string_view bytes);
void observations(std::string_view bytes);
void point_pairs(std::string_view bytes);
void trajectory(std::string_view bytes);
void pose_log(std::string_view bytes);
void run_log(std::string_view bytes);
void mcap(std::string_view bytes);

// What arrives by sockets; wire_fields: valid messages with drawn changes (poses.cpp, people.cpp, page.cpp).
void poses(std::string_view bytes);
void pose_stream(std::string_view bytes);
void osc(std::string_view bytes);
void psn(std::string_view bytes);
void rosbridge(std::string_view bytes);
void wire_fields(std::string_view bytes);
void skeletons(std::string_view bytes);
void skeleton_stream(std::string_view bytes);
void skeleton_csv(std::string_view bytes);
void foreign_skeletons(std::string_view bytes);
void vmc(std::string_view bytes);
void http(std::string_view bytes);
void editor(std::string_view bytes);

// Frames drawn in two ways (frames.cpp).
void kernels(std::string_view bytes);
void vector_widths(std::string_view bytes);
void renderers(std::string_view bytes);
void replay(std::string_view bytes);

}  // namespace procam::fuzz
