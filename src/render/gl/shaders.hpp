#pragma once
/// The renderer's programs: what src/render does to a pixel, in OpenGL's shading language. Each is kCommon,
/// its own text, and the version line before them.
namespace procam::render_gl {

extern const char* const kWholeFrame;  ///< vertices of one triangle that covers the framebuffer
extern const char* const kFacetBoxes;  ///< vertices of the boxes of a mesh's facets

extern const char* const kCommon;         ///< fragments: memory, rays, facets, footprints, samples
extern const char* const kFindHits;       ///< which facet of a mesh each pixel meets
extern const char* const kFindPlaneHits;  ///< and of a plane
extern const char* const kFindEdges;      ///< which pixels are cast at 16 times
extern const char* const kChooseTaps;     ///< how a block of pixels looks at an item
extern const char* const kDraw;           ///< a pixel's value; with EDGES defined, of those cast at 16 times
extern const char* const kCopy;           ///< into a window, whose rows are counted from below

/// Numbers that the programs and the renderer share.
inline constexpr int kListsUnit = 0, kNumbersUnit = 1, kContentUnit = 2, kRaysUnit = 3, kHitsUnit = 4,
                     kEdgesUnit = 5, kTapsUnit = 6, kValuesUnit = 7;
inline constexpr int kFacetTexels = 6;    ///< in the numbers
inline constexpr int kRecordTexels = 20;  ///< in the lists: one, and one a level of the content or mask
inline constexpr int kMaxGroups = 32;     ///< bits of the edges
inline constexpr int kBlocksAcross = 8;   ///< of a tile, that share their samples: 16 x 8 pixels
inline constexpr int kBlocksDown = 2;

}  // namespace procam::render_gl
