/**
 * What the server shows and what the page asks, as types. The Python side of each is
 * `app/page/shown.py` and `app/page/asked.py`, under the same names; a test compares them.
 */

/**
 * A numpy array: rows first.
 * @template {Float32Array | Uint8Array | Int32Array} [Data=Float32Array]
 * @typedef {{ shape: number[], data: Data }} Numbers
 */

/**
 * One robot. K moving nodes; positions in metres, angles in radians.
 * @typedef {object} RobotShown
 * @property {string} name
 * @property {string} root scene node that carries the robot; a copy has none of its own
 * @property {number | null} copy_of robot whose nodes it copies; null: its own nodes
 * @property {string[]} nodes (K) scene nodes that move; of the robot that it copies
 * @property {Numbers} rest_wxyz (K, 4)
 * @property {Numbers} rest_position (K, 3)
 * @property {Numbers} axes (K, 3) unit vectors in the node's frame
 * @property {Numbers<Uint8Array>} sliding (K) 1 where the joint slides
 * @property {Numbers<Int32Array>} columns (K) column of the motion that moves the node, -1 for none
 * @property {Numbers} factors (K) times the column,
 * @property {Numbers} offsets (K) plus this
 * @property {Numbers} spot (3) where it stands
 * @property {string[]} eyes scene nodes of the eyes' segments
 */
/** @typedef {{ robots: RobotShown[] }} RobotsShown */

/**
 * @typedef {object} MotionShown
 * @property {number} robot
 * @property {number} number of the motion, for what waits for it
 * @property {Numbers} angles (T, J)
 * @property {number} fps
 * @property {Numbers<Uint8Array> | null} eyes (T, 3 * segments) RGB
 * @property {Numbers | null} ghosts (K, T, J)
 * @property {boolean} samples whether the ghosts are samples of one belief
 * @property {boolean} ends whether the robot is gone after its last frame
 * @property {number | null} slot of the boards whose model generated it
 */

/**
 * @typedef {object} PlaybackShown
 * @property {number} number applied when it differs from the last one's
 * @property {boolean} playing
 * @property {number} frame
 * @property {number} speed
 * @property {boolean} loop
 */

/** @typedef {"class" | "valence" | "arousal"} Colouring */
/**
 * @typedef {object} MapShown
 * @property {number} slot which pair of boards, of two side by side
 * @property {number} model which one it is of
 * @property {string} title of the model
 * @property {number[]} axes components that are drawn: two, or one
 * @property {number[]} hidden_axes components that the toggle moves along, at most two
 * @property {string[]} axis_labels of the axes, then of the hidden ones
 * @property {Numbers} points (N, 2)
 * @property {string[]} names (N)
 * @property {Colouring} colouring
 * @property {string[]} classes (N)
 * @property {Numbers | null} values (N) from 0 to 1, NaN where there is none
 * @property {number | null} selected
 * @property {Numbers} extent (4) left, right, bottom, top of the whole map
 * @property {number} pairs of boards that are shown
 * @property {Numbers} added (A, 2) points of a person's own
 * @property {string[]} added_names (A)
 * @property {Numbers<Int32Array>} added_index (A) what to ask for
 */

/**
 * @typedef {object} PuckShown
 * @property {number} slot which pair of boards, of two side by side
 * @property {Numbers} on_map (2)
 * @property {Numbers | null} on_landscape (2)
 * @property {Numbers} hidden (H) along the hidden axes
 * @property {Numbers | null} covariance (2, 2) of N(mu, sigma^2) on the map
 * @property {Numbers | null} off_plane (N) distance of each learned point from the slice
 * @property {number | null} extrapolation distance to the nearest learned point over their spacing
 * @property {number | null} heard number of the last move that is in it
 */

/**
 * @typedef {object} LandscapeShown
 * @property {number} slot which pair of boards, of two side by side
 * @property {number} model which one it is of
 * @property {Numbers} correlation (R, C), row = second axis, both ascending; one row: a line
 * @property {Numbers} x (C)
 * @property {Numbers} y (R)
 * @property {Numbers} extent (4) left, right, bottom, top of all cells
 * @property {boolean} complete
 * @property {string[]} axis_labels
 * @property {string} window in words
 * @property {string} target in words
 * @property {number} mean
 * @property {number} area
 * @property {number} roughness
 * @property {Numbers | null} learned (M, 2) learned points within the window
 * @property {Numbers<Int32Array> | null} learned_index (M) which of the motions each is
 */

/**
 * A recognition's way on both boards; S iterates, M sampled PBs.
 * @typedef {object} PathShown
 * @property {number} slot which pair of boards, of two side by side
 * @property {Numbers | null} on_map (S, 2)
 * @property {Numbers | null} on_landscape (S, 2)
 * @property {Numbers} radii (S)
 * @property {Numbers | null} samples_on_map (M, 2)
 * @property {Numbers | null} samples_on_landscape (M, 2)
 * @property {number} shown iterate that is shown
 * @property {Numbers<Uint8Array> | null} early (M) whether mu jumped to a sample
 * @property {Numbers | null} others_on_map (K - 1, S, 2) the ways of other trials
 */

/**
 * Two ways from one motion to another, S steps each.
 * @typedef {object} WaysShown
 * @property {number} slot which pair of boards, of two side by side
 * @property {string} title of the model
 * @property {Numbers | null} straight (S + 1, 2) on the map; null: there is no way
 * @property {Numbers | null} shortest (S + 1, 2) on the map
 * @property {Numbers | null} changes (S) degrees that the motion changes in a step of the straight line
 * @property {Numbers | null} shortest_changes (S) of the shortest way
 * @property {number} steepest step of the straight line, from 0
 * @property {number | null} at step at which the models stand
 * @property {Numbers | null} shares (T) how far along a morph is in each frame, from 0 to 1
 */

/**
 * The belief over M entries of a codebook while S kept frames come in.
 * @typedef {object} CloudShown
 * @property {number} slot which pair of boards, of two side by side
 * @property {Numbers} frames (S) the last frame in each
 * @property {Numbers} places (M, 2) on the map
 * @property {Numbers<Uint8Array>} weights (S, M) roots of shares of the belief, 255 for the largest
 * @property {Numbers} entropy (S) bits
 * @property {Numbers} modes (G, 2) what it is torn between at the end
 * @property {Numbers} mass (G) share of the belief
 * @property {string[]} near (G) the learned motion that is nearest
 * @property {number} entries that were compared
 */

/**
 * @typedef {object} CurvesShown
 * @property {string[]} names (J)
 * @property {string[]} models (M) what the curves of each slot are called
 * @property {Numbers<Int32Array>} columns (M, J) of each slot's motion, where these joints are
 * @property {number | null} joint the one that is drawn; null: all
 * @property {Numbers | null} reference (T', J)
 * @property {Numbers | null} low (T, J) of a band; null: that of the samples
 * @property {Numbers | null} high (T, J)
 * @property {Numbers<Uint8Array> | null} unseen (J) whether a joint is inferred, not observed
 * @property {number | null} observed share of the reference that was observed; null: no handle
 * @property {number} active slot that all else is of
 */

/**
 * The part of a board that is looked at, while the board shows what it is `of`.
 * @typedef {{ of: string, left: number, right: number, bottom: number, top: number }} Zoom
 */
/**
 * @typedef {object} LookShown
 * @property {Zoom | null} map
 * @property {Zoom | null} landscape
 * @property {Zoom | null} map_2 of the second of two models side by side
 * @property {Zoom | null} landscape_2
 * @property {string} tab
 */
/** @typedef {{ text: string }} DocumentShown */

/**
 * Whether this page presents or follows.
 * @typedef {object} PresenceShown
 * @property {string} role "presents", "follows" or ""
 * @property {string | null} secret of who presents, for the tab to keep
 * @property {string} code for the link
 * @property {number} followers pages
 * @property {boolean} there whether somebody presents
 * @property {boolean} free whether this page has let go
 */

/**
 * @typedef {object} Shown everything that the server shows, by name
 * @property {RobotsShown} RobotsShown
 * @property {MotionShown} MotionShown
 * @property {PlaybackShown} PlaybackShown
 * @property {MapShown} MapShown
 * @property {PuckShown} PuckShown
 * @property {LandscapeShown} LandscapeShown
 * @property {PathShown} PathShown
 * @property {CloudShown} CloudShown
 * @property {WaysShown} WaysShown
 * @property {CurvesShown} CurvesShown
 * @property {LookShown} LookShown
 * @property {DocumentShown} DocumentShown
 * @property {PresenceShown} PresenceShown
 */

/** @typedef {"map" | "landscape"} BoardName */
/**
 * Everything that the page asks.
 * @typedef {(
 *   | { type: "Hello", document: string | null, width: number, height: number, ratio: number,
 *       page_width: number, page_height: number,
 *       dark: boolean, playback: { playing: boolean, frame: number, speed: number, loop: boolean } | null,
 *       present: string | null, follow: string | null, free: boolean }
 *   | { type: "MoveOnMap", model: number, axes: number[], to: number[], gesture: number, number: number, done: boolean }
 *   | { type: "MoveOnLandscape", model: number, axes: string[], to: number[], gesture: number, number: number, done: boolean }
 *   | { type: "SelectMotion", model: number, index: number }
 *   | { type: "SelectAdded", index: number }
 *   | { type: "WalkTo", step: number }
 *   | { type: "SetPlaying", playing: boolean, frame: number }
 *   | { type: "Seek", frame: number }
 *   | { type: "SetSpeed", speed: number }
 *   | { type: "SetLoop", loop: boolean }
 *   | { type: "SetJoint", joint: number | null }
 *   | { type: "SetObserved", share: number }
 *   | { type: "Looked", map: Zoom | null, landscape: Zoom | null, map_2: Zoom | null,
 *       landscape_2: Zoom | null, tab: string, turned: boolean }
 *   | { type: "Present", on: boolean }
 *   | { type: "Follow", on: boolean }
 *   | { type: "Undo" }
 *   | { type: "Redo" }
 *   | { type: "Resized", width: number, height: number, ratio: number,
 *       page_width: number, page_height: number }
 *   | { type: "Broken", reason: string }
 * )} Asked
 */
export const MESSAGE_TYPES = {
  down: "RnnpbShown",
  up: "RnnpbAsked",
};
