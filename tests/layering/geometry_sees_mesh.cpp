// Refused: geometry comes before mesh.
#include "common/mesh/submesh.h"
