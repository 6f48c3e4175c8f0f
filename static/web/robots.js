/**
 * The robots in the scene: viser's nodes posed from joint angles, and copies of them that share
 * their geometry (second robots, translucent ghosts of a motion's samples).
 */

import { requestRender, sceneNode } from "./bridge.js";
import { rotated, sampled, turned } from "./motion.js";

/** @typedef {import("./bridge.js").Node3} Node3 */
/** @typedef {import("./bridge.js").Material3} Material3 */
/** @typedef {import("./messages.js").RobotShown} RobotShown */
/** @typedef {import("./messages.js").MotionShown} MotionShown */
/** @typedef {{ source: Node3, meshes: number, root: Node3, nodes: (Node3 | undefined)[], eyes: Node3[][] }} Copy */

const GHOST_OPACITY = 0.2;
/** @type {[number, number, number]} */
const GHOST_COLOR = [0.3, 0.55, 0.95]; // white ghosts of a white robot would hardly be seen
const GHOST_ORDER = 10; // after what is solid
const CHECK_FRAMES = 20; // between two looks whether a robot's meshes have come
const SETTLE_FRAMES = 30; // viser sets its own pose on a node that is new

/** @type {(node: Node3) => number} */
const countMeshes = (node) =>
  node.children.reduce((sum, child) => sum + countMeshes(child), node.type === "Mesh" ? 1 : 0);

/**
 * A tree of groups and meshes once more; geometry is shared, so is what `paint` leaves of a material.
 * @param {Node3} node
 * @param {(material: Material3) => Material3} paint
 * @param {Map<Node3, Node3>} copies filled with every node's copy
 * @returns {Node3}
 */
function copied(node, paint, copies) {
  const copy = node.clone(false);
  copies.set(node, copy);
  if (copy.material) {
    copy.material = Array.isArray(copy.material) ? copy.material.map(paint) : paint(copy.material);
  }
  for (const child of node.children) {
    if (["Group", "Object3D", "Mesh"].includes(child.type)) copy.add(copied(child, paint, copies));
  }
  return copy;
}

/** The meshes at and below a node. @type {(node: Node3 | undefined) => Node3[]} */
const meshesOf = (node) =>
  node ? [...(node.type === "Mesh" ? [node] : []), ...node.children.flatMap(meshesOf)] : [];

/** Robot `shown`, on the nodes of `model` (itself, or the one that it copies). */
class Robot {
  /** @param {RobotShown} shown @param {RobotShown} model */
  constructor(shown, model) {
    this.shown = shown;
    this.model = model;
    /** @type {MotionShown | null} */ this.motion = null;
    /** @type {(Node3 | undefined)[]} */ this.nodes = [];
    /** @type {Copy[]} */ this.copies = []; // the robot itself where it is a copy, then its ghosts
    /** @type {Map<Material3, Material3>} */ this.ghostly = new Map();
    /** @type {WeakSet<Material3>} */ this.own = new WeakSet();
    this.angles = new Float32Array(0);
  }

  get isCopy() {
    return this.shown.copy_of !== null;
  }

  get ghosts() {
    return this.motion?.ghosts?.shape[0] ?? 0;
  }

  /** Whether viser has made nodes anew since the last look. */
  renewed() {
    let changed = false;
    this.model.nodes.forEach((name, k) => {
      const node = sceneNode(name);
      if (node === this.nodes[k]) return;
      this.nodes[k] = node;
      changed = true;
    });
    return changed;
  }

  /** Make the copies that are wanted and take away the others. @param {boolean} look whether meshes may have come */
  fitCopies(look) {
    const source = sceneNode(this.model.root);
    const wanted = (this.isCopy ? 1 : 0) + this.ghosts;
    const meshes = source && look ? countMeshes(source) : null;
    const stale = this.copies.some(
      (copy) => copy.source !== source || (meshes !== null && copy.meshes !== meshes),
    );
    if (stale) this.removeCopies(0);
    this.removeCopies(wanted);
    if (!source?.parent) return;
    while (this.copies.length < wanted) {
      const solid = this.isCopy && this.copies.length === 0;
      this.copies.push(this.makeCopy(source, solid));
    }
  }

  /** @param {Node3} source @param {boolean} solid @returns {Copy} */
  makeCopy(source, solid) {
    /** @type {Map<Node3, Node3>} */
    const copies = new Map();
    const root = copied(source, solid ? (one) => one : (one) => this.ghost(one), copies);
    if (!solid) {
      for (const mesh of meshesOf(root)) {
        mesh.castShadow = false;
        mesh.renderOrder = GHOST_ORDER;
      }
    }
    source.parent?.add(root);
    const partner = (/** @type {string} */ name) => {
      const node = sceneNode(name);
      return node && copies.get(node);
    };
    const nodes = this.model.nodes.map(partner);
    const eyes = this.model.eyes.map((name) => meshesOf(partner(name)));
    return { source, meshes: countMeshes(source), root, nodes, eyes };
  }

  /** @param {Material3} material @returns {Material3} */
  ghost(material) {
    let made = this.ghostly.get(material);
    if (!made) {
      made = material.clone();
      made.transparent = true;
      made.opacity = GHOST_OPACITY;
      made.depthWrite = false;
      made.color?.setRGB(...GHOST_COLOR, "srgb");
      // What stands where the solid robot stands is behind it: only what differs is seen.
      [made.polygonOffset, made.polygonOffsetFactor, made.polygonOffsetUnits] = [true, 2, 8];
      this.ghostly.set(material, made);
    }
    return made;
  }

  /** @param {number} from */
  removeCopies(from) {
    for (const { root } of this.copies.splice(from)) root.parent?.remove(root);
    if (this.copies.length > 0) return;
    for (const material of this.ghostly.values()) material.dispose();
    this.ghostly.clear();
  }

  /** @param {number} frame */
  pose(frame) {
    const { motion, shown } = this;
    if (!motion) return;
    const columns = motion.angles.shape[1] ?? 0;
    if (this.angles.length !== columns) this.angles = new Float32Array(columns);
    const [x, y, z] = shown.spot.data;
    sampled(motion.angles.data, columns, frame, this.angles);
    const own = this.isCopy ? this.copies[0]?.nodes : this.nodes;
    if (own) this.place(own);
    const root = this.isCopy ? this.copies[0]?.root : sceneNode(shown.root);
    root?.position.set(x, y, z);
    if (root && this.isCopy) {
      root.visible = !motion.ends || frame <= (motion.angles.shape[0] ?? 0) - 1;
    }
    this.colour(frame);
    const ghosts = this.copies.slice(this.isCopy ? 1 : 0);
    const size = (motion.angles.shape[0] ?? 0) * columns;
    ghosts.forEach((ghost, k) => {
      const angles = motion.ghosts?.data.subarray(k * size, (k + 1) * size) ?? [];
      sampled(angles, columns, frame, this.angles);
      this.place(ghost.nodes);
      ghost.root.position.set(x, y, z);
    });
  }

  /** Pose nodes as `angles` say. @param {(Node3 | undefined)[]} nodes */
  place(nodes) {
    const { rest_wxyz, rest_position, axes, sliding, columns, factors, offsets } = this.shown;
    nodes.forEach((node, k) => {
      if (!node) return;
      const column = columns.data[k];
      const value = offsets.data[k] + (column < 0 ? 0 : factors.data[k] * this.angles[column]);
      if (sliding.data[k]) {
        const [x, y, z] = rotated(rest_wxyz.data, axes.data, k).map((a) => a * value);
        const at = rest_position.data;
        node.position.set(at[3 * k] + x, at[3 * k + 1] + y, at[3 * k + 2] + z);
      } else {
        node.quaternion.set(...turned(rest_wxyz.data, axes.data, k, value));
      }
    });
  }

  /** @param {number} frame */
  colour(frame) {
    const eyes = this.motion?.eyes;
    if (!eyes) return;
    const segments = this.isCopy
      ? (this.copies[0]?.eyes ?? [])
      : this.model.eyes.map((name) => meshesOf(sceneNode(name)));
    const width = eyes.shape[1] ?? 0;
    const row = Math.min(Math.round(frame), (eyes.shape[0] ?? 1) - 1) * width;
    segments.forEach((meshes, i) => {
      const [r, g, b] = eyes.data.subarray(row + 3 * i, row + 3 * i + 3);
      for (const mesh of meshes)
        this.ownMaterial(mesh)?.color?.setRGB(r / 255, g / 255, b / 255, "srgb");
    });
  }

  /** A material that no other mesh shares. @param {Node3} mesh @returns {Material3 | undefined} */
  ownMaterial(mesh) {
    if (!mesh.material || Array.isArray(mesh.material)) return undefined;
    if (!this.own.has(mesh.material)) {
      mesh.material = mesh.material.clone();
      this.own.add(mesh.material);
    }
    return mesh.material;
  }
}

export class Robots {
  constructor() {
    /** @type {Robot[]} */ this.robots = [];
    /** @type {MotionShown[]} */ this.motions = []; // of robots that may still be to come
    this.looks = 0;
    this.unsettled = 0;
  }

  /** @param {import("./messages.js").RobotsShown} shown */
  show({ robots }) {
    for (const robot of this.robots) robot.removeCopies(0);
    this.robots = robots.map((one) => new Robot(one, robots[one.copy_of ?? -1] ?? one));
    this.robots.forEach((robot, i) => {
      robot.motion = this.motions[i] ?? null;
    });
    this.unsettled = SETTLE_FRAMES;
  }

  /** @param {MotionShown} motion */
  showMotion(motion) {
    this.motions[motion.robot] = motion;
    const robot = this.robots[motion.robot];
    if (robot) robot.motion = motion;
    this.unsettled = Math.max(this.unsettled, 1);
  }

  /** Frames of the longest motion, and their rate. */
  get length() {
    const motions = this.robots.flatMap(({ motion }) => (motion ? [motion] : []));
    return {
      frames: Math.max(0, ...motions.map(({ angles }) => angles.shape[0] ?? 0)),
      fps: motions[0]?.fps ?? 25,
    };
  }

  /**
   * Pose everything at a frame, where that changes anything.
   * @param {number} frame
   * @param {boolean} moved since the last call
   */
  pose(frame, moved) {
    this.looks += 1;
    const look = this.looks % CHECK_FRAMES === 0;
    for (const robot of this.robots) {
      const before = robot.copies.length;
      if (robot.renewed()) this.unsettled = SETTLE_FRAMES;
      robot.fitCopies(look);
      if (robot.copies.length !== before) this.unsettled = Math.max(this.unsettled, 2);
    }
    if (!moved && this.unsettled === 0) return;
    this.unsettled = Math.max(this.unsettled - 1, 0);
    for (const robot of this.robots) robot.pose(frame);
    requestRender();
  }
}
