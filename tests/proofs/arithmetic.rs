//! No double precision and no sine or square root of libm, called or inlined.

use tests::board;
use tests::image::Image;
use tests::reach::Reach;
use tests::stage;
use tests::variant;

use crate::BOARDS;

/// Run-time ABI for the Arm architecture (IHI0043), section 4.1.2, and libgcc's names of the same.
fn is_soft_float(name: &str) -> bool {
    const CONVERSIONS: [&str; 5] =
        ["__aeabi_f2d", "__aeabi_i2d", "__aeabi_ui2d", "__aeabi_l2d", "__aeabi_ul2d"];
    let name = name.rsplit("::").next().unwrap_or(name);
    name.starts_with("__aeabi_d")
        || name.starts_with("__aeabi_cd")
        || CONVERSIONS.contains(&name)
        || (name.starts_with("__") && name.contains("df"))
}

/// Functions of libm by their C names, single and double.
fn is_root_or_sine(name: &str) -> bool {
    const NAMES: [&str; 7] = ["sqrt", "sin", "cos", "sincos", "tan", "rem_pio2", "k_sin"];
    let name = name.rsplit("::").next().unwrap_or(name);
    NAMES.contains(&name.strip_suffix('f').unwrap_or(name))
}

/// Start of the function with this very name.
fn start(image: &Image, name: &str) -> u32 {
    let found = image.symbols.iter().find(|(at, n)| n == name && image.functions.contains_key(at));
    found.unwrap_or_else(|| panic!("no function is called {name}")).0
}

/// What is slow below `roots`: ways to functions, and addresses of inlined code.
fn slow(image: &Image, roots: &[u32], parts_of_inlined: &[&str]) -> Result<Vec<String>, String> {
    let reach = Reach::from(image, roots)?;
    let mut found = reach.ways_to(|n| is_soft_float(n) || is_root_or_sine(n));
    let inlined = stage::attribute(image, &[("slow", parts_of_inlined)])?;
    let inlined = inlined.iter().filter(|(at, hit)| hit.is_some() && reach.contains(*at));
    found.extend(inlined.map(|(at, _)| format!("inlined at {at:#x}")));
    Ok(found)
}

/// A tick uses nothing of libm at all.
const ALL_OF_LIBM: &[&str] = &["libm::"];
const ROOT_AND_SINE: &[&str] =
    &["libm::math::sqrt", "libm::math::sin", "libm::math::cos", "libm::math::tan", "rem_pio2"];

#[test]
fn the_tick_has_neither_double_precision_nor_libm() {
    for (board, root) in BOARDS.into_iter().zip(["tick", "TIM2"]) {
        let image = board::open(board);
        let found = slow(&image, &[start(&image, root)], ALL_OF_LIBM).expect("a call graph");
        assert!(found.is_empty(), "{board}: {found:#?}");
    }
}

#[test]
fn interrupts_and_idle_have_neither_double_precision_nor_roots_and_sines() {
    for board in BOARDS {
        let image = board::open(board);
        let found = slow(&image, &image.vectors, ROOT_AND_SINE).expect("a call graph");
        assert!(found.is_empty(), "{board}: {found:#?}");
    }
}

/// Route two: the same search where something is to be found.
#[test]
fn slow_arithmetic_is_found() {
    let path = variant::build("soft_float").expect("a variant");
    let image = Image::open(&path).expect("a readable image");
    let found = slow(&image, &[start(&image, "tick")], ROOT_AND_SINE).expect("a call graph");
    // The compiler inlines the root, so only the debug information tells of it.
    for part in ["tick > __aeabi_dmul", "__muldf3", "__aeabi_f2d", "inlined"] {
        assert!(found.iter().any(|way| way.contains(part)), "{part}: {found:#?}");
    }
    // The set-up alone uses the exponential.
    let ordinary = board::open("mps2-an386");
    let found = slow(&ordinary, &ordinary.vectors, ALL_OF_LIBM).expect("a call graph");
    assert!(!found.is_empty());
}

#[test]
fn slow_functions_are_told_by_their_names() {
    for name in ["__aeabi_dadd", "__aeabi_cdcmple", "__aeabi_ui2d", "__extendsfdf2", "__ledf2"] {
        assert!(is_soft_float(name), "{name}");
    }
    for name in ["__aeabi_memcpy", "__aeabi_uldivmod", "__aeabi_idiv", "firmware::law::adapt"] {
        assert!(!is_soft_float(name), "{name}");
    }
    for name in ["sqrtf", "libm::math::sinf::sinf", "cos", "libm::math::k_sinf::k_sinf"] {
        assert!(is_root_or_sine(name), "{name}");
    }
    assert!(!is_root_or_sine("libm::math::expf::expf") && !is_root_or_sine("f"));
}

#[test]
fn a_call_through_a_register_is_refused_by_name() {
    let image = board::open("demo");
    let refusal = Reach::from(&image, &[start(&image, "PendSV")]).err().expect("a refusal");
    assert!(refusal.starts_with("PendSV") && refusal.contains("unknown target"), "{refusal}");
}
