//! Overlays: groups of settings that may be missing, to be laid over one another.

/// Declares a struct of optional settings with the private method `laid_under`, which merges two of them. The fields are
/// named here once.
macro_rules! overlay {
    (
        $(#[$($meta:tt)*])*
        pub struct $name:ident {
            $($(#[$($attribute:tt)*])* pub $field:ident: Option<$type:ty>,)*
        }
    ) => {
        $(#[$($meta)*])*
        pub struct $name {
            $($(#[$($attribute)*])* pub $field: Option<$type>,)*
        }

        impl $name {
            /// Each setting of `over`, or that of `self` where `over` has none.
            fn laid_under(self, over: Self) -> Self {
                Self { $($field: over.$field.or(self.$field),)* }
            }
        }
    };
}

pub(super) use overlay;
