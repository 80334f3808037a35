import {buildPage} from "./page.js";
import {SpatialStage} from "./motion/spatial_stage.js";

buildPage(SpatialStage);
