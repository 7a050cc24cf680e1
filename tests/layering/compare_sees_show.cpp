// Refused: a stage does not see a sibling.
#include "server/show/overlay.h"
