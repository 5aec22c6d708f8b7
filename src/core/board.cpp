#include "procam/core/board/detail/artwork_index_body.hpp"
#include "procam/core/board/detail/board_artwork_body.hpp"
#include "procam/core/board/detail/board_body.hpp"
